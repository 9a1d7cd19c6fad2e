//! Data sets: a capture again and again, from other poses, under other conditions.

mod finished;
mod folder;
mod layout_folder;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use glam::DVec2;
use serde_json::Value;

pub use finished::{read_dataset, read_present};
pub use folder::{DatasetFolder, PartFolder};
pub use layout_folder::LayoutFolder;

use folder::{NewPicture, Turn, identity, part_identity};

use crate::calibration::dataset::{Plan, RigCamera, Subject};
use crate::calibration::targets::PlacedTarget;
use crate::calibration::truth::TruthLayer;
use crate::capture::{Capture, DatasetFile};
use crate::pipeline::{
    Event, FilmMemory, LightSource, Monitor, OutputFolder, Request, check_samples, render_into, standalone_camera,
};
use crate::report::Timings;
use crate::sensor::SensorModel;
use crate::{Error, Invalid, Result, Sandbox};

/// Between two looks at what other processes make, at first and after a while.
const SHORTEST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// A data set file with all that it needs.
pub struct DataSet {
    file: DatasetFile,
    capture_path: PathBuf,
    plan: Plan,
    /// Of each camera, before anything is varied.
    captures: Vec<Capture>,
    /// Changes to the capture, after those of the file.
    arguments: Vec<String>,
    film_memory: FilmMemory,
    identity: Value,
}

impl DataSet {
    /// Reads a data set file with the captures of its cameras; `arguments` change their keys, after those of the file.
    pub fn read(sandbox: &Sandbox, input: &Path, arguments: &[String], film_memory: FilmMemory) -> Result<Self> {
        let file = DatasetFile::read(input)?;
        let capture_path = input.parent().unwrap_or(Path::new("")).join(&file.description.capture);
        sandbox.check(&capture_path).map_err(|invalid| file.error(invalid.within("capture")))?;
        let (plan, captures) = plan(&file, sandbox, &capture_path, arguments)?;
        let identity = identity(&file, &captures, arguments)?;
        Ok(Self { file, capture_path, plan, captures, arguments: arguments.to_vec(), film_memory, identity })
    }

    /// All changes to the capture in the frames of these numbers, for each camera. Poses that cannot be had show here
    /// rather than after an hour.
    pub fn frames(&self, numbers: Range<u32>) -> Result<BTreeMap<u32, Vec<Vec<String>>>> {
        let frame = |number| {
            let frame = self.plan.frame(number, &self.arguments).map_err(|invalid| self.file.error(invalid))?;
            Ok((number, frame))
        };
        numbers.map(frame).collect()
    }

    /// The names of the rig's cameras.
    pub fn cameras(&self) -> impl Iterator<Item = &str> {
        self.plan.cameras().iter().map(|camera| &*camera.place.name)
    }

    /// The capture of a camera in a frame. What is wrong with a change is wrong with the key that asks for it.
    fn capture(&self, camera: &str, number: u32, overrides: &[String]) -> Result<Capture> {
        let capture = Capture::load_within(self.captures[0].source.sandbox(), &self.capture_path, overrides);
        capture.map_err(|error| self.error_of_change(error, camera, number, overrides))
    }

    fn error_of_change(&self, error: Error, camera: &str, number: u32, overrides: &[String]) -> Error {
        let is_of_file = |change: &&String| !self.arguments.contains(change);
        let changes: Vec<String> = overrides.iter().filter(is_of_file).cloned().collect();
        self.file.error_of_change(error, camera, Some(number), &changes)
    }

    /// Makes all pictures of the frames that are not there, with the light that a camera has in a frame, and returns
    /// how many those were.
    pub fn make(
        &self,
        frames: &BTreeMap<u32, Vec<Vec<String>>>,
        folder: &DatasetFolder,
        monitor: &dyn Monitor,
        light: impl Fn(&str, u32) -> Result<LightSource>,
    ) -> Result<usize> {
        let pictures = frames.iter().flat_map(|(number, frame)| {
            self.cameras().zip(frame).map(move |(camera, overrides)| (*number, camera, overrides))
        });
        if self.captures.iter().any(|capture| capture.sensor.image_lag.is_some()) {
            monitor.report(Event::Warning(
                "the pictures of a data set are made one by one, maybe by several processes: each starts without the charge that \
                 sensor.charge.image_lag keeps from the frame before",
            ));
        }
        let mut todo: Vec<_> = pictures.filter(|&(number, camera, _)| !folder.is_done(camera, number)).collect();
        monitor.report(Event::SetBegins { pictures: todo.len() as u64 });
        let _until_end = UntilSetEnds(monitor);
        let (mut made, mut is_first) = (0, true);
        let mut pause = SHORTEST_PAUSE;
        while !todo.is_empty() {
            // What other processes make is looked at again in the end: they may die.
            let mut theirs = Vec::new();
            for (number, camera, overrides) in todo {
                let picture = match folder.begin(camera, number)? {
                    Turn::Ours(picture) => picture,
                    Turn::Theirs => {
                        theirs.push((number, camera, overrides));
                        continue;
                    }
                    Turn::Done => {
                        monitor.report(Event::PictureEnds);
                        continue;
                    }
                };
                let light = light(camera, number)?;
                // Warnings about the scene are given once.
                let monitor = OfOnePicture { monitor, warns: std::mem::take(&mut is_first) };
                self.picture((number, camera), overrides, light, &picture, &monitor)?;
                made += usize::from(picture.finish()?);
                monitor.report(Event::PictureEnds);
            }
            todo = theirs;
            if !todo.is_empty() {
                if pause == SHORTEST_PAUSE {
                    monitor.report(Event::Waiting { pictures: todo.len() });
                }
                sleep(pause);
                pause = LONGEST_PAUSE.min(pause * 2);
            }
        }
        Ok(made)
    }

    /// Makes one picture, but for its name.
    fn picture(
        &self,
        (number, camera): (u32, &str),
        overrides: &[String],
        light: LightSource,
        picture: &NewPicture,
        monitor: &dyn Monitor,
    ) -> Result<()> {
        // It was read before, with all that it names.
        let capture = self.capture(camera, number, overrides).map_err(Error::since_begun)?;
        let mut results = OutputFolder::own(picture.path());
        let request = Request {
            input: &self.capture_path,
            named: self.file.description.capture.clone(),
            overrides: overrides.to_vec(),
            light,
            film_memory: self.film_memory,
            monitor,
            is_timed: false,
        };
        let rendered = render_into(capture, &request, &mut results, Timings::default());
        rendered.map(|_| ()).map_err(|error| self.error_of_change(error, camera, number, overrides))
    }

    /// Writes the summary of the images: how many are there, and which files of the cameras are left out,
    /// with the reasons.
    pub fn write_index(&self, folder: &DatasetFolder) -> Result<(usize, Vec<String>)> {
        folder.write_index(&self.file, &self.identity, &self.plan)
    }

    /// How many pictures, or parts of pictures, a folder holds.
    pub fn present(&self, folder: &DatasetFolder) -> usize {
        let done = |number| self.cameras().filter(|camera| folder.is_done(camera, number)).count();
        (0..self.plan.frames()).map(done).sum()
    }

    /// The frames that the file asks for.
    pub fn frame_count(&self) -> u32 {
        self.plan.frames()
    }

    /// Takes a folder for the whole data set.
    pub fn claim(&self, path: &Path) -> Result<DatasetFolder> {
        DatasetFolder::claim(path, &self.identity, &self.plan)
    }

    /// Takes a folder for a part of every picture, of a data set that was read from `input`.
    pub fn claim_part(&self, path: &Path, samples: &Range<u32>, input: &Path) -> Result<DatasetFolder> {
        DatasetFolder::claim(path, &part_identity(&self.identity, samples, input), &self.plan)
    }

    /// Refuses samples that are no part of what the captures ask for.
    pub fn check_samples(&self, samples: &Range<u32>) -> Result<()> {
        self.captures.iter().try_for_each(|capture| check_samples(samples, capture))
    }

    /// Refuses a folder with a part of another data set.
    pub fn check_part(&self, part: &PartFolder) -> Result<()> {
        part.check(&self.identity)
    }

    /// Reads the captures of the first of these frames: keys that there are not show before anything is made.
    pub fn check_first(&self, frames: &BTreeMap<u32, Vec<Vec<String>>>) -> Result<()> {
        let Some((number, frame)) = frames.first_key_value() else { return Ok(()) };
        self.cameras().zip(frame).try_for_each(|(camera, changes)| self.capture(camera, *number, changes).map(|_| ()))
    }
}

/// What is heard of one picture of a set: that it was cancelled, and warnings of the first alone.
struct OfOnePicture<'a> {
    monitor: &'a dyn Monitor,
    warns: bool,
}

impl Monitor for OfOnePicture<'_> {
    fn report(&self, event: Event<'_>) {
        match event {
            Event::Warning(_) if self.warns => self.monitor.report(event),
            // While a picture is traced it stops by itself and keeps a checkpoint.
            Event::TraceBegins { .. } | Event::TraceEnds => self.monitor.report(event),
            Event::Warning(_)
            | Event::Traced(_)
            | Event::PassEnds { .. }
            | Event::SetBegins { .. }
            | Event::PictureEnds
            | Event::Waiting { .. }
            | Event::SetEnds => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        self.monitor.is_cancelled()
    }
}

/// Reports the end of a set whichever way it ends.
struct UntilSetEnds<'a>(&'a dyn Monitor);

impl Drop for UntilSetEnds<'_> {
    fn drop(&mut self) {
        self.0.report(Event::SetEnds);
    }
}

/// What frames there are, and the capture of each camera as it is before anything is varied.
fn plan(
    file: &DatasetFile,
    sandbox: &Sandbox,
    capture_path: &Path,
    overrides: &[String],
) -> Result<(Plan, Vec<Capture>)> {
    let description = &file.description;
    let rig = description.rig().map_err(|invalid| file.error(invalid))?;
    let mut cameras = Vec::new();
    let mut captures = Vec::new();
    for place in rig {
        let set: Vec<String> = place.set.iter().chain(overrides).cloned().collect();
        let read = || {
            let capture = Capture::load_within(sandbox, capture_path, &set)?;
            check(&capture)?;
            let camera = standalone_camera(&capture)?;
            Ok((camera, capture))
        };
        let read = read().map_err(|error| file.error_of_change(error, &place.name, None, &place.set));
        let (camera, capture) = read?;
        // Cameras of a rig of which nothing else is stated are specimens of their own.
        let serial = capture.sensor.serial.saturating_add(if place.is_numbered { 0 } else { captures.len() as u64 });
        let seed = capture.render.seed;
        // A variation may ask for flow in some frames.
        let varies_truth = description.vary.iter().any(|variation| variation.key.trim().starts_with("output"));
        let flows = varies_truth || capture.output.truth.layers.contains(&TruthLayer::Flow);
        cameras.push(RigCamera { place, camera, serial, seed, flows });
        captures.push(capture);
    }
    for (index, camera) in cameras.iter().enumerate() {
        if let Some(other) = cameras[..index].iter().find(|other| other.serial == camera.serial) {
            let (name, number) = (&other.place.name, camera.serial);
            let message = format!("has the serial number {number} of {name}, and so the same fixed pattern");
            let invalid = Invalid::new(format!("cameras[{index}]"), message);
            return Err(file.error(invalid.help("give each a sensor.serial of its own in its `set`")));
        }
    }
    for (index, camera) in cameras.iter().enumerate() {
        let Some(partner) = camera.place.partner else { continue };
        let (own, other) = (&captures[index], &captures[partner]);
        let geometry = |capture: &Capture| {
            let SensorModel { resolution, pixel_pitch_m, shutter, .. } = capture.sensor;
            (resolution, pixel_pitch_m, shutter)
        };
        if own.lens != other.lens || geometry(own) != geometry(other) {
            let message = "disparity is that of two cameras of one kind, and lens or sensor of the other differ";
            let key = format!("cameras[{index}].disparity_to");
            return Err(file.error(Invalid::new(key, message).help("remove it, or give both the same `set`")));
        }
    }
    let subjects = subjects(&captures[0]);
    let start = captures[0].camera_to_world;
    let plan = Plan::new(description, cameras, &subjects, start).map_err(|invalid| file.error(invalid))?;
    Ok((plan, captures))
}

/// The targets that poses can be taken around: those who look for one want all of its sheet.
fn subjects(capture: &Capture) -> Vec<Subject> {
    let of_target = |target: &PlacedTarget| {
        let [low, high] = target.target.sheet;
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let points = corners.map(|corner| target.world(corner)).to_vec();
        Subject { name: target.name.clone(), to_world: target.to_world, points }
    };
    capture.targets.iter().map(of_target).collect()
}

/// What a capture must not ask for in a data set.
fn check(capture: &Capture) -> Result<()> {
    let refuse =
        |key: &str, message: &str, help: &str| Err(capture.source.error(Invalid::new(key, message).help(help)));
    if capture.exposure.frames != 1 {
        return refuse("exposure.frames", "a data set makes its own series", "remove it");
    }
    if capture.render.time_limit.is_some() {
        let help = "write samples_per_pixel or noise_target";
        return refuse("render.time_limit_s", "would make another data set each time", help);
    }
    Ok(())
}
