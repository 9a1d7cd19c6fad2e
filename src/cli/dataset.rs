//! `photosite dataset`: a capture again and again, from other poses, under other conditions.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use clap::Args;
use glam::DVec2;
use photosite::calibration::dataset::{Plan, RigCamera, Subject};
use photosite::calibration::targets::PlacedTarget;
use photosite::calibration::truth::TruthLayer;
use photosite::io::capture::{Capture, DatasetFile};
use photosite::sensor::SensorModel;
use photosite::{Error, Invalid, Result};
use serde_json::{Value, json};

use super::dataset_folder::{DatasetFolder, NewPicture, Turn, identity, part_identity};
use super::film_memory::FilmMemory;
use super::output_folder::OutputFolder;
use super::parts::check_samples;
use super::progress::Progress;
use super::render::{Light, Request, lone_camera, render};
use super::report::Timings;
use super::{parse_range, print_json, start_threads};

/// Between two looks at what other processes make, at first and after a while.
const SHORTEST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// Render a data set: a capture from many poses, under many conditions, by one camera or a rig.
///
/// Each frame is a folder as `photosite render` makes it, DIR/CAMERA/NUMBER. A data set that was broken off goes on where it
/// stopped when the same command is given again. Several processes and machines can share the work: by the same command in
/// the same folder, where each picture is made by one of them, with frames of their own (--frames) if they like, or each
/// with samples of its own (--samples) in a folder of its own.
#[derive(Args)]
pub(super) struct DatasetArgs {
    /// A data set file (.toml), which names a capture file and says what differs from frame to frame.
    input: PathBuf,
    /// Folder of the data set, created where missing [default: the input's name, in the current folder].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Make these frames only: from A up to, but without, B; 0..10 are the first ten.
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    frames: Option<Range<u32>>,
    /// Trace these samples of every pixel only: from A up to, but without, B. `photosite merge` makes one data set of the
    /// folders of all parts.
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    samples: Option<Range<u32>>,
    /// Change a key of the capture file in all frames, for example --set render.samples_per_pixel=16.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Threads to use [default: all cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    #[command(flatten)]
    film_memory: FilmMemory,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print what was made on standard output.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &DatasetArgs) -> Result<()> {
    start_threads(args.threads)?;
    let set = DataSet::read(&args.input, &args.overrides, args.film_memory)?;
    if let Some(samples) = &args.samples {
        set.captures.iter().try_for_each(|capture| check_samples(samples, capture))?;
    }
    let numbers = args.frames.clone().unwrap_or(0..set.plan.frames());
    if numbers.end > set.plan.frames() {
        let message = format!("--frames {}..{}: there are {} frames", numbers.start, numbers.end, set.plan.frames());
        return Err(Error::Usage { message, help: Some(format!("write at most 0..{}", set.plan.frames())) });
    }
    let frames = set.frames(numbers)?;
    // Keys that there are not show now, as do poses that cannot be had.
    if let Some((number, frame)) = frames.first_key_value() {
        set.cameras().zip(frame).try_for_each(|(camera, changes)| set.capture(camera, *number, changes).map(|_| ()))?;
    }
    let default = PathBuf::from(&*args.input.file_stem().unwrap_or_default().to_string_lossy());
    let path = args.output.as_deref().unwrap_or(&default);
    let talk = Talk { quiet: args.quiet, json: args.json };
    let Some(samples) = &args.samples else {
        let folder = DatasetFolder::claim(path, &set.identity, &set.plan)?;
        let made = set.make(&frames, &folder, talk, |_, _| Ok(Light::Traced))?;
        return set.finish(&folder, made, talk);
    };
    let folder = DatasetFolder::claim(path, &part_identity(&set.identity, samples, &args.input), &set.plan)?;
    let made = set.make(&frames, &folder, talk, |_, _| Ok(Light::Part(samples.clone())))?;
    set.finish_part(&folder, made, talk)
}

/// What is said on the way.
#[derive(Clone, Copy)]
pub(super) struct Talk {
    pub(super) quiet: bool,
    pub(super) json: bool,
}

/// A data set file with all that it needs.
pub(super) struct DataSet {
    file: DatasetFile,
    capture_path: PathBuf,
    pub(super) plan: Plan,
    /// Of each camera, before anything is varied.
    captures: Vec<Capture>,
    /// Changes to the capture, after those of the file.
    arguments: Vec<String>,
    film_memory: FilmMemory,
    pub(super) identity: Value,
}

impl DataSet {
    pub(super) fn read(input: &Path, arguments: &[String], film_memory: FilmMemory) -> Result<Self> {
        let file = DatasetFile::read(input)?;
        let capture_path = input.parent().unwrap_or(Path::new("")).join(&file.description.capture);
        let (plan, captures) = plan(&file, &capture_path, arguments)?;
        let identity = identity(&file, &captures, arguments)?;
        Ok(Self { file, capture_path, plan, captures, arguments: arguments.to_vec(), film_memory, identity })
    }

    /// All changes to the capture in the frames of these numbers, for each camera. Poses that cannot be had show here rather than
    /// after an hour.
    pub(super) fn frames(&self, numbers: Range<u32>) -> Result<BTreeMap<u32, Vec<Vec<String>>>> {
        let frame = |number| {
            let frame = self.plan.frame(number, &self.arguments).map_err(|invalid| self.file.error(invalid))?;
            Ok((number, frame))
        };
        numbers.map(frame).collect()
    }

    /// The names of the rig's cameras.
    pub(super) fn cameras(&self) -> impl Iterator<Item = &str> {
        self.plan.cameras().iter().map(|camera| &*camera.place.name)
    }

    /// The capture of a camera in a frame. What is wrong with a change is wrong with the key that asks for it.
    fn capture(&self, camera: &str, number: u32, overrides: &[String]) -> Result<Capture> {
        let capture = Capture::read(&self.capture_path, overrides);
        capture.map_err(|error| self.error_of_change(error, camera, number, overrides))
    }

    fn error_of_change(&self, error: Error, camera: &str, number: u32, overrides: &[String]) -> Error {
        let is_of_file = |change: &&String| !self.arguments.contains(change);
        let changes: Vec<String> = overrides.iter().filter(is_of_file).cloned().collect();
        self.file.error_of_change(error, camera, Some(number), &changes)
    }

    /// Makes all pictures of the frames that are not there, with the light that a camera has in a frame, and returns how many
    /// those were.
    pub(super) fn make(
        &self,
        frames: &BTreeMap<u32, Vec<Vec<String>>>,
        folder: &DatasetFolder,
        talk: Talk,
        light: impl Fn(&str, u32) -> Result<Light>,
    ) -> Result<usize> {
        let pictures = frames.iter().flat_map(|(number, frame)| {
            self.cameras().zip(frame).map(move |(camera, overrides)| (*number, camera, overrides))
        });
        if !talk.quiet && self.captures.iter().any(|capture| capture.sensor.image_lag.is_some()) {
            eprintln!(
                "warning: the pictures of a data set are made one by one, maybe by several processes: each starts without the \
                 charge that sensor.charge.image_lag keeps from the frame before"
            );
        }
        let mut todo: Vec<_> = pictures.filter(|&(number, camera, _)| !folder.is_done(camera, number)).collect();
        let progress = Progress::over_images(todo.len() as u64, talk.quiet || talk.json);
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
                        progress.advance(1);
                        continue;
                    }
                };
                let light = light(camera, number)?;
                // What is to be said of the scene is said once.
                let quiet = talk.quiet || !std::mem::take(&mut is_first);
                self.picture((number, camera), overrides, light, &picture, quiet)?;
                made += usize::from(picture.finish()?);
                progress.advance(1);
            }
            todo = theirs;
            if !todo.is_empty() {
                if pause == SHORTEST_PAUSE && !talk.quiet {
                    eprintln!("other processes are making {} pictures, which are waited for", todo.len());
                }
                sleep(pause);
                pause = LONGEST_PAUSE.min(pause * 2);
            }
        }
        progress.finish();
        Ok(made)
    }

    /// Makes one picture, but for its name.
    fn picture(
        &self,
        (number, camera): (u32, &str),
        overrides: &[String],
        light: Light,
        picture: &NewPicture,
        quiet: bool,
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
            quiet,
            silent: true,
            is_timed: false,
        };
        let rendered = render(capture, &request, &mut results, Timings::default());
        rendered.map(|_| ()).map_err(|error| self.error_of_change(error, camera, number, overrides))
    }

    /// Writes what is said of the pictures together.
    pub(super) fn finish(&self, folder: &DatasetFolder, made: usize, talk: Talk) -> Result<()> {
        let (present, left_out) = folder.write_index(&self.file, &self.identity, &self.plan)?;
        if !talk.quiet {
            left_out.iter().for_each(|why| eprintln!("warning: calibration/ is without {}", why.replace('`', "")));
        }
        self.tell(folder, [made, present], "pictures", talk)
    }

    /// Of parts nothing is said together: they are no pictures.
    fn finish_part(&self, folder: &DatasetFolder, made: usize, talk: Talk) -> Result<()> {
        let done = |number| self.cameras().filter(|camera| folder.is_done(camera, number)).count();
        let present = (0..self.plan.frames()).map(done).sum();
        self.tell(folder, [made, present], "parts of pictures", talk)
    }

    fn tell(&self, folder: &DatasetFolder, [made, present]: [usize; 2], what: &str, talk: Talk) -> Result<()> {
        let (frames, cameras) = (self.plan.frames(), self.plan.cameras().len());
        let all = frames as usize * cameras;
        if talk.json {
            return print_json(&json!({
                "folder": folder.path(),
                "frames": frames,
                "cameras": cameras,
                "made": made,
                "present": present,
                "complete": present == all,
            }));
        }
        if !talk.quiet {
            eprintln!("made {made} {what}; {present} of {all} {what} are in {}", folder.path().display());
        }
        Ok(())
    }
}

/// What frames there are, and the capture of each camera as it is before anything is varied.
fn plan(file: &DatasetFile, capture_path: &Path, overrides: &[String]) -> Result<(Plan, Vec<Capture>)> {
    let description = &file.description;
    let rig = description.rig().map_err(|invalid| file.error(invalid))?;
    let mut cameras = Vec::new();
    let mut captures = Vec::new();
    for place in rig {
        let set: Vec<String> = place.set.iter().chain(overrides).cloned().collect();
        let read = || {
            let capture = Capture::read(capture_path, &set)?;
            check(&capture)?;
            let camera = lone_camera(&capture)?;
            Ok((camera, capture))
        };
        let read = read().map_err(|error| file.error_of_change(error, &place.name, None, &place.set));
        let (camera, capture) = read?;
        // Cameras of a rig that are not told otherwise are specimens of their own.
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
