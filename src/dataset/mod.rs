//! Data sets: a capture again and again, from other poses, under other conditions.

mod calibration;
#[cfg(test)]
mod claim_model;
mod epipolar_lines;
mod failure;
mod file_pattern;
mod finished;
mod folder;
mod forecast;
mod frames;
mod heartbeat;
mod identity;
mod index;
mod jobs;
mod layout_folder;
mod made;
mod make;
mod merge;
mod noise;
mod overlays;
mod parts;
mod picture;
mod place;
mod presence;
mod rectified_truth;
mod rectify;
mod rig;
mod said;
mod selection;
mod shapes;
mod sheet;
mod status;
mod varied;
mod verify;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use rayon::prelude::*;
use serde_json::Value;

pub use failure::Failure;
pub use finished::{read_dataset, read_present};
pub use folder::DatasetFolder;
pub use forecast::{Forecast, duration, size};
pub use frames::Frames;
pub use heartbeat::Holder;
pub use identity::IDENTITY;
pub use index::Index;
pub use layout_folder::LayoutFolder;
pub use made::Made;
pub use make::MakeOptions;
pub use noise::SetNoise;
pub use overlays::{Corner, Epipolar, Overlays, SeenObject};
pub use parts::PartFolder;
pub use presence::name as picture_name;
pub use rectify::{RectifiedReport, RectifySettings, disparity_scale, rectify};
pub use selection::{FrameList, Shard};
pub use sheet::{Sheet, SheetPicture};
pub use status::{PictureState, PictureStatus, Status};

use identity::{identity, part_identity};
use place::Places;
use presence::{damage, picture};
use rig::plan;

use crate::calibration::dataset::Plan;
use crate::capture::{Capture, DatasetFile};
use crate::optics::Focus;
use crate::pipeline::{Event, FilmMemory, Monitor, Prepared, check_samples};
use crate::report::Look;
use crate::{Error, Invalid, Result, Sandbox};

/// A data set file with all that it needs.
pub struct DataSet {
    file: DatasetFile,
    capture_path: PathBuf,
    plan: Plan,
    /// Of each camera, before anything is varied.
    captures: Vec<Capture>,
    /// What has other places in each frame.
    places: Places,
    /// Changes to the capture, after those of the file.
    arguments: Vec<String>,
    film_memory: FilmMemory,
    identity: Value,
    /// What the next picture of a camera may have in common with its last one.
    kept: Mutex<BTreeMap<String, Prepared>>,
}

impl DataSet {
    /// The data set of a file with the captures of its cameras; `arguments` change their keys, after those of the file.
    pub fn new(sandbox: &Sandbox, file: DatasetFile, arguments: &[String], film_memory: FilmMemory) -> Result<Self> {
        let capture_path = file.capture();
        sandbox.check(&capture_path).map_err(|invalid| file.error(invalid.within("capture")))?;
        let (plan, captures, found) = plan(&file, sandbox, &capture_path, arguments)?;
        let places = Places::read(&file, sandbox, &captures[0])?;
        let identity = identity(&file, captures.iter().chain(places.all()), arguments, (&plan, &found))?;
        Ok(Self {
            file,
            capture_path,
            plan,
            captures,
            places,
            arguments: arguments.to_vec(),
            film_memory,
            identity,
            kept: Mutex::default(),
        })
    }

    /// Plans the frames of these numbers: poses that cannot be had show here rather than after an hour. With
    /// `keeps_going` a frame that cannot be had is reported and left out.
    pub fn frames(
        &self,
        numbers: impl IntoIterator<Item = u32>,
        keeps_going: bool,
        monitor: &dyn Monitor,
    ) -> Result<Frames> {
        let mut frames = Frames::default();
        for number in numbers {
            match self.plan.frame(number, &self.arguments).map_err(|invalid| self.file.error(invalid)) {
                Ok(changes) => drop(frames.changes.insert(number, changes)),
                Err(error) if keeps_going => {
                    monitor.report(Event::PictureFails { camera: "", frame: number, error: &error });
                    frames.failed.push(number);
                    frames.reasons.insert(number, Failure::of(&error));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(frames)
    }

    /// All pictures of these frames, with the changes to the capture that make them.
    fn pictures<'a>(&'a self, frames: &'a Frames) -> impl Iterator<Item = (u32, &'a str, &'a [String])> {
        let of_frame = |(number, changes): (&'a u32, &'a Vec<Vec<String>>)| {
            let number = *number;
            self.cameras().zip(changes).map(move |(camera, changes)| (number, camera, &**changes))
        };
        frames.changes.iter().flat_map(of_frame)
    }

    /// The names of the rig's cameras.
    pub fn cameras(&self) -> impl Iterator<Item = &str> {
        self.plan.cameras().iter().map(|camera| &*camera.place.name)
    }

    /// The capture of a camera in a frame, with all objects in their places.
    fn capture(&self, camera: &str, number: u32, overrides: &[String]) -> Result<Capture> {
        // All cameras of a rig see what the first one sees.
        let before = || {
            let changes = self.plan.frame(number, &self.arguments).map_err(|invalid| self.file.error(invalid))?;
            self.cameras()
                .zip(changes)
                .map(|(camera, changes)| self.described(camera, number, &changes))
                .next()
                .unwrap_or_else(|| self.described(camera, number, overrides))
        };
        match self.places.change(&self.plan, number, &self.file, before)? {
            None => self.described(camera, number, overrides),
            Some(change) => self.described(camera, number, &[overrides, &[change]].concat()),
        }
    }

    /// The capture of a camera in a frame, before objects are placed. What is wrong with a change is wrong with the key
    /// that asks for it.
    fn described(&self, camera: &str, number: u32, overrides: &[String]) -> Result<Capture> {
        let before = self.cameras().position(|name| name == camera).unwrap_or(0);
        let capture = self.captures[before].with_all(overrides);
        capture.map_err(|error| self.error_of_change(error, camera, number, overrides))
    }

    fn error_of_change(&self, error: Error, camera: &str, number: u32, overrides: &[String]) -> Error {
        let is_of_file = |change: &&String| !self.arguments.contains(change);
        let changes: Vec<String> = overrides.iter().filter(is_of_file).cloned().collect();
        self.file.error_of_change(error, camera, Some(number), &changes)
    }

    /// Writes the summary of the pictures.
    pub fn write_index(&self, folder: &DatasetFolder) -> Result<Index> {
        let focuses = self.captures.iter().any(|capture| matches!(capture.lens.focus, Focus::Autofocus { .. }));
        index::write_index(folder, &self.file, &self.identity, (&self.plan, focuses))
    }

    /// Which of these frames lack a picture, or a part of one, in the folder at `path`, which need not be there.
    pub fn missing(&self, numbers: Vec<u32>, path: &Path) -> Vec<u32> {
        let lacks = |camera: &str, number| damage(&picture(path, camera, number), Look::Sizes).is_some();
        let numbers = numbers.into_par_iter();
        numbers.filter(|&number| self.cameras().any(|camera| lacks(camera, number))).collect()
    }

    /// How many pictures, or parts of pictures, a folder holds.
    pub fn present(&self, folder: &DatasetFolder) -> usize {
        let done = |number| self.cameras().filter(|camera| folder.is_done(camera, number)).count();
        (0..self.plan.frames()).map(done).sum()
    }

    /// The fingerprint of all that decides what is in its pictures.
    pub fn fingerprint(&self) -> &str {
        self.identity.get("fingerprint").and_then(Value::as_str).unwrap_or_default()
    }

    /// The frames that the file asks for.
    pub fn frame_count(&self) -> u32 {
        self.plan.frames()
    }

    /// Refuses a folder that cannot be taken for the data set, and changes nothing.
    pub fn check_folder(&self, path: &Path) -> Result<()> {
        folder::check_folder(path, &self.identity)
    }

    /// Takes a folder for the whole data set.
    pub fn claim(&self, path: &Path) -> Result<DatasetFolder> {
        DatasetFolder::claim(path, &self.identity, &self.plan)
    }

    /// The folder of the whole data set, which must be there.
    pub fn open(&self, path: &Path) -> Result<DatasetFolder> {
        if !PartFolder::is_one(path) {
            let help = "give the folder of the data set";
            return Err(Invalid::new("", "does not contain a data set").help(help).in_file(path));
        }
        self.claim(path)
    }

    /// Takes a folder for a part of every picture, of a data set that was read from `input`.
    pub fn claim_part(&self, path: &Path, samples: &Range<u32>, input: &Path) -> Result<DatasetFolder> {
        DatasetFolder::claim(path, &part_identity(&self.identity, samples, input), &self.plan)
    }

    /// Samples of each pixel that all pictures have.
    pub fn samples(&self) -> Result<u32> {
        let samples = self.captures[0].render.samples_per_pixel;
        let decides = |key: &str| key == "render.samples_per_pixel" || key == "render";
        let is_varied = self.plan.varied_keys().into_iter().any(decides);
        if is_varied || self.captures.iter().any(|capture| capture.render.samples_per_pixel != samples) {
            let help = "write one number of samples, or share the work by frames";
            let invalid = Invalid::new("render.samples_per_pixel", "differs from picture to picture");
            return Err(self.file.error(invalid.help(help)));
        }
        self.check_samples(&(0..samples))?;
        Ok(samples)
    }

    /// Refuses samples that are no part of what the captures ask for.
    pub fn check_samples(&self, samples: &Range<u32>) -> Result<()> {
        self.captures.iter().try_for_each(|capture| check_samples(samples, capture))
    }

    /// Reads the captures of the first of these frames: keys that there are not show before anything is made.
    pub fn check_first(&self, frames: &Frames) -> Result<()> {
        let mut first = self.pictures(frames).take(self.cameras().count());
        first.try_for_each(|(number, camera, changes)| self.capture(camera, number, changes).map(drop))
    }
}
