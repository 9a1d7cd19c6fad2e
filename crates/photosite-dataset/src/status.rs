//! Status of a data set, by its folder alone: which images are done, under way, failed, damaged, missing.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;

use super::failure::Failure;
use super::heartbeat::{Holder, Sign, now_s, sign};
use super::identity::{CAMERAS, FRAMES, IDENTITY, of_part, read_identity};
use super::image_folder::{damage, failure, image, lock, name};
use super::read_dataset::{Line, MANIFEST};
use super::selection::{FrameList, in_order};
use photosite_capture::report::CheckDepth;
use photosite_core::input;
use photosite_core::{Error, Invalid, Result};

/// Status of a data set.
#[derive(Clone, Debug)]
pub struct Status {
    /// Folder of the data set.
    pub folder: PathBuf,
    /// Number of frames of the whole data set.
    pub frames: u32,
    /// Names of the cameras.
    pub cameras: Vec<String>,
    /// Range of samples of each pixel and the data set file, for a folder of parts.
    pub part: Option<([u32; 2], PathBuf)>,
    /// Changes to the capture that the data set was begun with.
    pub overrides: Vec<String>,
    /// All images, frame by frame.
    pub images: Vec<ImageStatus>,
    /// Cameras whose folders cannot be written to, so that it is unknown how long ago anything happened.
    pub timeless: Vec<String>,
}

/// Status of an image.
#[derive(Clone, Debug, Serialize)]
pub struct ImageStatus {
    /// Name of the camera.
    pub camera: String,
    /// Number of the frame.
    pub frame: u32,
    /// Folder of the image within that of the data set, whether or not it is there.
    pub folder: String,
    /// State of the image.
    #[serde(flatten)]
    pub state: ImageState,
}

/// State of an image.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "state", rename_all = "lowercase")]
pub enum ImageState {
    /// The image is there, with all of its files.
    Done,
    /// A process makes the image.
    Running {
        /// Holder of the lock, if it has stated itself.
        #[serde(flatten)]
        holder: Option<Holder>,
        /// Time since the holder began, s, if known.
        age_s: Option<f64>,
        /// Time since the last heartbeat, s, if known.
        silence_s: Option<f64>,
    },
    /// The image could not be made.
    Failed(Failure),
    /// The image is there, but damaged.
    Damaged {
        /// Damage.
        message: String,
    },
    /// The image is not there.
    Missing,
}

impl Status {
    /// Reads the status of a data set, or of a part of one, from its folder.
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
        let images = all.par_iter().map(|&(frame, c)| ImageStatus {
            camera: cameras[c].clone(),
            frame,
            folder: name(&cameras[c], frame),
            state: state(folder, &cameras[c], frame, times[c]),
        });
        let images = images.collect();
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
            images,
            timeless,
        })
    }

    /// Number of images whose state meets a condition.
    pub fn count(&self, is_one: impl Fn(&ImageState) -> bool) -> usize {
        self.images.iter().filter(|image| is_one(&image.state)).count()
    }

    /// Frames with images that are missing or damaged and that no process is making.
    pub fn to_make(&self) -> FrameList {
        let is_to_make = |image: &&ImageStatus| match image.state {
            ImageState::Failed(_) | ImageState::Damaged { .. } | ImageState::Missing => true,
            ImageState::Done | ImageState::Running { .. } => false,
        };
        let numbers = self.images.iter().filter(is_to_make).map(|image| image.frame).collect();
        FrameList::of(&in_order(numbers))
    }
}

/// Whether some process makes an image in the folder of a camera, or has left its lock.
fn has_locks(folder: &Path) -> bool {
    let entries = input::entries(folder).into_iter().flatten().flatten();
    entries.into_iter().any(|entry| entry.file_name().to_string_lossy().ends_with(".lock"))
}

/// State of an image. Its maker may end meanwhile, so that its lock is looked at before its files.
fn state(folder: &Path, camera: &str, number: u32, now_s: Option<f64>) -> ImageState {
    let path = image(folder, camera, number);
    let is_done = || damage(&path, CheckDepth::Sizes).is_none();
    if is_done() {
        return ImageState::Done;
    }
    if let Some(Sign { holder, age_s, silence_s }) = sign(&lock(folder, camera, number), now_s) {
        return ImageState::Running { holder, age_s, silence_s };
    }
    match damage(&path, CheckDepth::Sizes) {
        None => ImageState::Done,
        Some(message) if path.exists() => ImageState::Damaged { message },
        Some(_) => match Failure::read(&failure(folder, camera, number)) {
            Some(failure) => ImageState::Failed(failure),
            None => ImageState::Missing,
        },
    }
}

/// Number of frames of the whole data set, and the cameras. Folders of earlier versions state them by their manifest.
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
