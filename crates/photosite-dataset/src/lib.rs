//! Data sets: a capture again and again, from other poses, under other conditions.

#![forbid(unsafe_code)]

mod calibration;
#[cfg(test)]
mod claim_model;
pub mod emva1288;
mod epipolar_lines;
mod failure;
mod file_pattern;
mod folder;
mod forecast;
mod frames;
mod heartbeat;
mod identity;
mod image_folder;
mod index;
mod jobs;
mod layout_folder;
mod make;
mod merge;
mod noise;
mod outcome;
mod overlays;
mod parts;
mod placement;
mod read_dataset;
mod rectified_truth;
mod rectify;
mod render_image;
mod rig;
mod selection;
mod shapes;
mod sheet;
mod status;
mod varied;
mod verify;
mod warnings_by_kind;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use rayon::prelude::*;
use serde_json::Value;

pub use failure::Failure;
pub use folder::DatasetFolder;
pub use forecast::Forecast;
pub use frames::Frames;
pub use heartbeat::Holder;
pub use identity::IDENTITY;
pub use image_folder::name as image_name;
pub use index::Index;
pub use layout_folder::LayoutFolder;
pub use make::MakeOptions;
pub use noise::SetNoise;
pub use outcome::DatasetOutcome;
pub use overlays::{Corner, Epipolar, Overlays, SeenObject};
pub use parts::PartFolder;
pub use read_dataset::{read_dataset, read_present};
pub use rectify::{RectifiedReport, RectifySettings, disparity_scale, rectify};
pub use selection::{FrameList, Shard};
pub use sheet::{Sheet, SheetImage};
pub use status::{ImageState, ImageStatus, Status};

use identity::{identity, part_identity};
use image_folder::{damage, image};
use placement::Places;
use rig::plan;

use photosite_calibration::dataset::Plan;
use photosite_capture::report::CheckDepth;
use photosite_capture::{Capture, DatasetFile};
use photosite_core::{Error, Invalid, Result, Sandbox};
use photosite_pipeline::{DeviceChoice, Event, FilmMemory, Monitor, Prepared, check_samples};
use photosite_transport::integrator::Device;
use photosite_transport::optics::Focus;

/// Data set file with everything that it needs.
pub struct DataSet {
    file: DatasetFile,
    capture_path: PathBuf,
    plan: Plan,
    /// Capture of each camera, before anything is varied.
    captures: Vec<Capture>,
    /// Objects that get other places in each frame.
    places: Places,
    /// Changes to the capture, after those of the file.
    arguments: Vec<String>,
    film_memory: FilmMemory,
    identity: Value,
    /// Prepared scene of each camera's last image, which its next one may share.
    kept: Mutex<BTreeMap<String, Prepared>>,
}

impl DataSet {
    /// Data set of a file with the captures of its cameras; `arguments` change their keys, after those of the file.
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

    /// The data set, whose light the chosen device traces. A card must be able to render its captures as they are before
    /// anything is varied; a frame in which it cannot is an error of that frame.
    pub fn on_chosen_device(self, choice: &DeviceChoice, monitor: &dyn Monitor) -> Result<Self> {
        let device = choice.device_for(&self.captures, monitor)?;
        Ok(self.on_device(device))
    }

    /// The data set, whose light a device traces in place of the processor, and which is another data set for it: the
    /// last bits of its images depend on it.
    #[must_use]
    pub fn on_device(mut self, device: Option<Arc<dyn Device>>) -> Self {
        if let Some(device) = device {
            self.identity = identity::on_device(&self.identity, &device.name());
            self.captures = self.captures.into_iter().map(|capture| capture.on_device(device.clone())).collect();
        }
        self
    }

    /// Plans the frames of these numbers, so that impossible poses show here rather than after an hour. With
    /// `keeps_going`, a frame that cannot be planned is reported and left out.
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
                    monitor.report(Event::ImageFails { camera: "", frame: number, error: &error });
                    frames.failed.push(number);
                    frames.reasons.insert(number, Failure::of(&error));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(frames)
    }

    /// All images of these frames, with the changes to the capture that make them.
    fn images<'a>(&'a self, frames: &'a Frames) -> impl Iterator<Item = (u32, &'a str, &'a [String])> {
        let of_frame = |(number, changes): (&'a u32, &'a Vec<Vec<String>>)| {
            let number = *number;
            self.cameras().zip(changes).map(move |(camera, changes)| (number, camera, &**changes))
        };
        frames.changes.iter().flat_map(of_frame)
    }

    /// Names of the rig's cameras.
    pub fn cameras(&self) -> impl Iterator<Item = &str> {
        self.plan.cameras().iter().map(|camera| &*camera.place.name)
    }

    /// Capture of a camera in a frame, with all objects in their places.
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

    /// Capture of a camera in a frame, before objects are placed. An error of a change is reported for the key that
    /// asks for it.
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

    /// Writes manifest, calibration files and card of the images.
    pub fn write_index(&self, folder: &DatasetFolder) -> Result<Index> {
        let focuses = self.captures.iter().any(|capture| matches!(capture.lens().focus, Focus::Autofocus { .. }));
        index::write_index(folder, &self.file, &self.identity, (&self.plan, focuses))
    }

    /// Frames among these that lack an image, or a part of one, in the folder at `path`, which need not exist.
    pub fn missing(&self, numbers: Vec<u32>, path: &Path) -> Vec<u32> {
        let lacks = |camera: &str, number| damage(&image(path, camera, number), CheckDepth::Sizes).is_some();
        let numbers = numbers.into_par_iter();
        numbers.filter(|&number| self.cameras().any(|camera| lacks(camera, number))).collect()
    }

    /// Number of images, or parts of images, in a folder.
    pub fn present(&self, folder: &DatasetFolder) -> usize {
        let done = |number| self.cameras().filter(|camera| folder.is_done(camera, number)).count();
        (0..self.plan.frames()).map(done).sum()
    }

    /// Fingerprint of everything that decides the content of the images.
    pub fn fingerprint(&self) -> &str {
        self.identity.get("fingerprint").and_then(Value::as_str).unwrap_or_default()
    }

    /// Number of frames that the file asks for.
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

    /// Opens the folder of the whole data set, which must exist.
    pub fn open(&self, path: &Path) -> Result<DatasetFolder> {
        if !PartFolder::is_one(path) {
            let help = "give the folder of the data set";
            return Err(Invalid::new("", "does not contain a data set").help(help).in_file(path));
        }
        self.claim(path)
    }

    /// Claims a folder for a part of every image, of a data set that was read from `input`.
    pub fn claim_part(&self, path: &Path, samples: &Range<u32>, input: &Path) -> Result<DatasetFolder> {
        DatasetFolder::claim(path, &part_identity(&self.identity, samples, input), &self.plan)
    }

    /// Samples per pixel, which all images have in common.
    pub fn samples(&self) -> Result<u32> {
        let samples = self.captures[0].render().samples_per_pixel;
        let decides = |key: &str| key == "render.samples_per_pixel" || key == "render";
        let is_varied = self.plan.varied_keys().into_iter().any(decides);
        if is_varied || self.captures.iter().any(|capture| capture.render().samples_per_pixel != samples) {
            let help = "write one number of samples, or share the work by frames";
            let invalid = Invalid::new("render.samples_per_pixel", "differs from image to image");
            return Err(self.file.error(invalid.help(help)));
        }
        self.check_samples(&(0..samples))?;
        Ok(samples)
    }

    /// Refuses a range of samples beyond those of the captures.
    pub fn check_samples(&self, samples: &Range<u32>) -> Result<()> {
        self.captures.iter().try_for_each(|capture| check_samples(samples, capture))
    }

    /// Reads the captures of the first of these frames, so that unknown keys show before anything is made.
    pub fn check_first(&self, frames: &Frames) -> Result<()> {
        let mut first = self.images(frames).take(self.cameras().count());
        first.try_for_each(|(number, camera, changes)| self.capture(camera, number, changes).map(drop))
    }
}
