//! How far a data set is, by its folder alone: what is done, under way, failed, damaged, missing.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;

use super::failure::Failure;
use super::finished::{Line, MANIFEST};
use super::heartbeat::{Holder, Sign, now_s, sign};
use super::identity::{CAMERAS, FRAMES, IDENTITY, of_part, read_identity};
use super::presence::{damage, failure, lock, name, picture};
use super::selection::{FrameList, in_order};
use crate::report::Look;
use crate::{Error, Invalid, Result};
use photosite_core::input;

/// How far a data set is.
#[derive(Clone, Debug)]
pub struct Status {
    /// The folder.
    pub folder: PathBuf,
    /// How many frames there are to be.
    pub frames: u32,
    /// The cameras that take them.
    pub cameras: Vec<String>,
    /// Of a part of every picture: which samples of each pixel, and the data set file.
    pub part: Option<([u32; 2], PathBuf)>,
    /// The changes to the capture that it was begun with.
    pub overrides: Vec<String>,
    /// All pictures, frame by frame.
    pub pictures: Vec<PictureStatus>,
    /// Cameras into whose folders nothing can be written, so that it is not known how long ago anything was.
    pub timeless: Vec<String>,
}

/// How far a picture is.
#[derive(Clone, Debug, Serialize)]
pub struct PictureStatus {
    /// The camera that takes it.
    pub camera: String,
    /// The number of the frame.
    pub frame: u32,
    /// Where it is, or will be, in the folder of the data set.
    pub folder: String,
    /// How far it is.
    #[serde(flatten)]
    pub state: PictureState,
}

/// How far a picture is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "state", rename_all = "lowercase")]
pub enum PictureState {
    /// It is there, with all of its files.
    Done,
    /// A process makes it.
    Running {
        /// Who it is, if it has said so.
        #[serde(flatten)]
        holder: Option<Holder>,
        /// For how long it has been at it, s, if that can be known.
        age_s: Option<f64>,
        /// How long ago it gave a sign of life, s, if that can be known.
        silence_s: Option<f64>,
    },
    /// It could not be made.
    Failed(Failure),
    /// It is there, and something is wrong with it.
    Damaged {
        /// What.
        message: String,
    },
    /// It is not there.
    Missing,
}

impl Status {
    /// Looks at the folder of a data set, or of a part of one.
    pub fn read(folder: &Path) -> Result<Self> {
        let marker = folder.join(IDENTITY);
        if !marker.exists() {
            let message = format!("{} does not contain a data set", folder.display());
            let help = "give the folder that `photosite dataset` fills, the one after its -o";
            return Err(Error::Usage { message, help: Some(help.into()) });
        }
        let identity = read_identity(&marker)?;
        if !identity.get("fingerprint").is_some_and(Value::is_string) {
            let help = "run the command that makes the data set with another folder";
            return Err(Invalid::new("", "is damaged: it has no fingerprint").help(help).in_file(&marker));
        }
        let (frames, cameras) = extent(folder, &identity)?;
        // Where nothing is being made, nobody asks for the time.
        let time_in = |folder: PathBuf| if has_locks(&folder) { now_s(&folder) } else { None };
        let times: Vec<Option<f64>> = cameras.iter().map(|camera| time_in(folder.join(camera))).collect();
        let all: Vec<(u32, usize)> =
            (0..frames).flat_map(|frame| (0..cameras.len()).map(move |c| (frame, c))).collect();
        let pictures = all.par_iter().map(|&(frame, c)| PictureStatus {
            camera: cameras[c].clone(),
            frame,
            folder: name(&cameras[c], frame),
            state: state(folder, &cameras[c], frame, times[c]),
        });
        let pictures = pictures.collect();
        let is_timeless = |&(camera, time): &(&String, &Option<f64>)| time.is_none() && has_locks(&folder.join(camera));
        let timeless = cameras.iter().zip(&times).filter(is_timeless).map(|(camera, _)| camera.clone()).collect();
        let overrides =
            identity.get("overrides").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str);
        Ok(Self {
            folder: folder.to_owned(),
            frames,
            part: part(&identity),
            overrides: overrides.map(str::to_owned).collect(),
            cameras,
            pictures,
            timeless,
        })
    }

    /// How many pictures are in a state of which this is true.
    pub fn count(&self, is_one: impl Fn(&PictureState) -> bool) -> usize {
        self.pictures.iter().filter(|picture| is_one(&picture.state)).count()
    }

    /// The frames with pictures that nobody makes and that are not there, or not as they were.
    pub fn to_make(&self) -> FrameList {
        let is_to_make = |picture: &&PictureStatus| match picture.state {
            PictureState::Failed(_) | PictureState::Damaged { .. } | PictureState::Missing => true,
            PictureState::Done | PictureState::Running { .. } => false,
        };
        let numbers = self.pictures.iter().filter(is_to_make).map(|picture| picture.frame).collect();
        FrameList::of(&in_order(numbers))
    }
}

/// Whether somebody makes a picture in the folder of a camera, or has left the lock of one.
fn has_locks(folder: &Path) -> bool {
    let entries = input::entries(folder).into_iter().flatten().flatten();
    entries.into_iter().any(|entry| entry.file_name().to_string_lossy().ends_with(".lock"))
}

/// How far a picture is. Whoever makes it may end meanwhile: its lock is looked at before what it leaves.
fn state(folder: &Path, camera: &str, number: u32, now_s: Option<f64>) -> PictureState {
    let path = picture(folder, camera, number);
    let is_done = || damage(&path, Look::Sizes).is_none();
    if is_done() {
        return PictureState::Done;
    }
    if let Some(Sign { holder, age_s, silence_s }) = sign(&lock(folder, camera, number), now_s) {
        return PictureState::Running { holder, age_s, silence_s };
    }
    match damage(&path, Look::Sizes) {
        None => PictureState::Done,
        Some(message) if path.exists() => PictureState::Damaged { message },
        Some(_) => match Failure::read(&failure(folder, camera, number)) {
            Some(failure) => PictureState::Failed(failure),
            None => PictureState::Missing,
        },
    }
}

/// How many frames there are to be, and the cameras. Folders of earlier versions tell it by their manifest.
fn extent(folder: &Path, identity: &Value) -> Result<(u32, Vec<String>)> {
    let frames = identity.get(FRAMES).and_then(Value::as_u64).and_then(|frames| u32::try_from(frames).ok());
    let cameras: Vec<String> = identity
        .get(CAMERAS)
        .and_then(Value::as_array)
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
        .map(str::to_owned)
        .collect();
    if let (Some(frames), false) = (frames, cameras.is_empty()) {
        return Ok((frames, cameras));
    }
    let text = input::read_text(&folder.join(MANIFEST), input::TABLE_BYTES).unwrap_or_default();
    let lines: Vec<Line> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let mut cameras: Vec<String> = Vec::new();
    for line in &lines {
        if !cameras.contains(&line.camera) {
            cameras.push(line.camera.clone());
        }
    }
    match lines.last() {
        Some(line) => Ok((line.frames, cameras)),
        None => {
            let message = "does not say how many frames there are: it was started by an earlier version of photosite";
            let help = "run the command that makes the data set again, with --index-only if it should make nothing";
            Err(Invalid::new("", message).help(help).in_file(&folder.join(IDENTITY)))
        }
    }
}

fn part(identity: &Value) -> Option<([u32; 2], PathBuf)> {
    let samples = serde_json::from_value(of_part(identity, "samples")?.clone()).ok()?;
    Some((samples, PathBuf::from(of_part(identity, "path")?.as_str()?)))
}
