//! `photosite dataset`: a capture again and again, from other poses, under other conditions.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec2;
use photosite::calibration::dataset::{Plan, RigCamera, Subject};
use photosite::calibration::targets::PlacedTarget;
use photosite::io::capture::{Capture, DatasetFile};
use photosite::{Error, Invalid, Result};
use serde_json::json;

use super::dataset_folder::{DatasetFolder, identity};
use super::output_folder::OutputFolder;
use super::progress::Progress;
use super::render::{Request, lone_camera, render};
use super::report::Timings;
use super::{print_json, start_threads};

/// Render a data set: a capture from many poses, under many conditions, by one camera or a rig.
///
/// Each frame is a folder as `photosite render` makes it, DIR/CAMERA/NUMBER. A data set that was broken off goes on where it
/// stopped when the same command is given again. Several machines can share the work, each with frames of its own
/// (--frames) in the same folder.
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
    /// Change a key of the capture file in all frames, for example --set render.samples_per_pixel=16.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Threads to use [default: all cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print what was made on standard output.
    #[arg(long)]
    json: bool,
}

fn parse_range(text: &str) -> Result<Range<u32>, String> {
    let number = |part: &str| part.trim().parse::<u32>().ok();
    let ends = text.split_once("..").and_then(|(a, b)| Some((number(a)?, number(b)?)));
    match ends {
        Some((a, b)) if a < b => Ok(a..b),
        Some(_) => Err("the first number must be below the second".to_owned()),
        None => Err("write two whole numbers, for example 0..10".to_owned()),
    }
}

pub(super) fn run(args: &DatasetArgs) -> Result<()> {
    start_threads(args.threads)?;
    let file = DatasetFile::read(&args.input)?;
    let capture_path = args.input.parent().unwrap_or(Path::new("")).join(&file.description.capture);
    let (plan, captures) = plan(&file, &capture_path, &args.overrides)?;
    let numbers = args.frames.clone().unwrap_or(0..plan.frames());
    if numbers.end > plan.frames() {
        let message = format!("--frames {}..{}: there are {} frames", numbers.start, numbers.end, plan.frames());
        return Err(Error::Usage { message, help: Some(format!("write at most 0..{}", plan.frames())) });
    }
    // Poses that cannot be had show now rather than after an hour.
    let frames: BTreeMap<u32, Vec<Vec<String>>> = numbers
        .map(|number| Ok((number, plan.frame(number).map_err(|invalid| file.error(invalid))?)))
        .collect::<Result<_>>()?;
    let overrides = |number: u32, camera: usize| -> Vec<String> {
        frames[&number][camera].iter().chain(&args.overrides).cloned().collect()
    };
    // As do keys that there are not.
    if let Some(&first) = frames.keys().next() {
        (0..plan.cameras().len())
            .try_for_each(|camera| Capture::read(&capture_path, &overrides(first, camera)).map(|_| ()))?;
    }
    let default = PathBuf::from(&*args.input.file_stem().unwrap_or_default().to_string_lossy());
    let identity = identity(&file, &captures, &args.overrides)?;
    let folder = DatasetFolder::claim(args.output.as_deref().unwrap_or(&default), &identity, &plan)?;

    let todo: Vec<(u32, usize)> = frames
        .keys()
        .flat_map(|&number| (0..plan.cameras().len()).map(move |camera| (number, camera)))
        .filter(|&(number, camera)| !folder.is_done(&plan.cameras()[camera].place.name, number))
        .collect();
    let progress = Progress::over_images(todo.len() as u64, args.quiet || args.json);
    for (made, &(number, camera)) in todo.iter().enumerate() {
        let overrides = overrides(number, camera);
        let capture = Capture::read(&capture_path, &overrides)?;
        let partial = folder.begin(&plan.cameras()[camera].place.name, number)?;
        let mut results = OutputFolder::claim(&partial, false)?;
        // What is to be said of the scene is said once.
        let quiet = args.quiet || made > 0;
        let request = Request { input: &capture_path, overrides, quiet, silent: true, is_timed: false };
        render(capture, &request, &mut results, Timings::default())?;
        drop(results);
        folder.finish(&plan.cameras()[camera].place.name, number)?;
        progress.advance(1);
    }
    progress.finish();
    let present = folder.write_index(&file, &identity, &plan)?;
    let (images, cameras) = (plan.frames() as usize * plan.cameras().len(), plan.cameras().len());
    if args.json {
        return print_json(&json!({
            "folder": folder.path(),
            "frames": plan.frames(),
            "cameras": cameras,
            "made": todo.len(),
            "present": present,
            "complete": present == images,
        }));
    }
    if !args.quiet {
        let images = format!("{present} of {images} pictures are in {}", folder.path().display());
        eprintln!("made {} pictures; {images}", todo.len());
    }
    Ok(())
}

/// What frames there are, and the capture of each camera as it is before anything is varied.
fn plan(file: &DatasetFile, capture_path: &Path, overrides: &[String]) -> Result<(Plan, Vec<Capture>)> {
    let description = &file.description;
    let rig = description.rig().map_err(|invalid| file.error(invalid))?;
    let mut cameras = Vec::new();
    let mut captures = Vec::new();
    for place in rig {
        let set: Vec<String> = place.set.iter().chain(overrides).cloned().collect();
        let capture = Capture::read(capture_path, &set)?;
        check(&capture)?;
        let camera = lone_camera(&capture)?;
        cameras.push(RigCamera { place, camera });
        captures.push(capture);
    }
    for (index, camera) in cameras.iter().enumerate() {
        let Some(partner) = camera.place.partner else { continue };
        let (own, other) = (&captures[index], &captures[partner]);
        if own.lens != other.lens || own.sensor.resolution != other.sensor.resolution {
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
