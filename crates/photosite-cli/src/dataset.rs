//! `photosite dataset`: a capture again and again, from other poses, under other conditions.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use clap::Args;
use photosite_core::counted;
use serde_json::json;

use super::arguments::parse_range;
use super::log::{say, warning};
use super::monitor::TerminalMonitor;
use super::print::{print_json, println_out};
use super::scene_args::SceneArgs;
use photosite_capture::DatasetFile;
use photosite_core::sandbox::trust;
use photosite_core::{Result, Sandbox};
use photosite_dataset::{
    DataSet, DatasetFolder, DatasetOutcome, Forecast, FrameList, Frames, MakeOptions, SetNoise, Shard, image_name,
};
use photosite_pipeline::{DeviceChoice, Event, FilmMemory, ImageOfFrame, LightSource, Monitor};

const EXAMPLES: &str = "\
Examples:
  photosite dataset dataset.toml -o set --dry-run
  photosite dataset dataset.toml -o set --shard 3/8";

/// Render a data set: many poses, conditions and cameras.
///
/// Each frame is a folder as `photosite render` makes it, DIR/CAMERA/NUMBER. A data set that was interrupted
/// continues where it stopped when the same command is run again; images that have lost a file are made again.
/// Several processes and machines can share the work: with the same command in the same folder, where each image
/// is made by one of them; with frames of their own (--frames, --shard); or each with samples of its own
/// (--samples) in a folder of its own.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct DatasetArgs {
    /// A data set file (.toml), which names a capture file and says what differs from frame to frame.
    input: PathBuf,
    /// Folder of the data set, created where missing [default: the input's name, in the current folder].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Make only these frames: numbers, and ranges from A up to, but not including, B; 0..4,9 are the first four
    /// and the tenth. Frames that do not exist are ignored.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<FrameList>,
    /// Make the K-th of N equal shares of the frames.
    #[arg(long, value_name = "K/N", allow_hyphen_values = true)]
    shard: Option<Shard>,
    /// Trace only these samples of every pixel: from A up to, but not including, B. `photosite merge` makes one data
    /// set of the folders of all parts.
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    samples: Option<Range<u32>>,
    /// Continue after frames that cannot be made, and end with status 1 if there were any.
    #[arg(long)]
    keep_going: bool,
    /// Make this many images at once, which share the threads [default: one for each thread where images are small,
    /// else 1].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Make no images: check the keys of every frame, and estimate the time, memory and disk space that the missing
    /// images would take.
    #[arg(long, conflicts_with_all = ["samples", "index_only", "verify"])]
    dry_run: bool,
    /// Make no images: write manifest.jsonl, calibration/ and README.md again, and end with status 1 if an image
    /// is missing.
    #[arg(long, conflicts_with = "samples")]
    index_only: bool,
    /// Read every file of the existing images, and make damaged ones again; with --index-only, name them and end
    /// with status 1.
    #[arg(long)]
    verify: bool,
    /// Change a key of the capture file in all frames, for example --set render.samples_per_pixel=16.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    #[command(flatten)]
    scene: SceneArgs,
    /// Maximum memory for the film, GiB: an image of which it needs more is traced in strips, one after the other.
    #[arg(long, value_name = "GIB", default_value = "4")]
    film_memory: FilmMemory,
    /// Device that traces the light: cpu; gpu, the first graphics card; gpu:1 or gpu:NAME, one of `photosite devices`;
    /// auto, a graphics card where there is one that has what the settings ask for. One data set is of one device.
    #[arg(long, value_name = "DEVICE", default_value = "cpu")]
    device: DeviceChoice,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print what is made on standard output, one object per line: `"event": "picture"` for each image, `"end"` last.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &DatasetArgs, sandbox: &Sandbox) -> Result<()> {
    let (report, monitor) = (SetReport::of(args.quiet, args.json), TerminalMonitor::new(args.quiet, args.json));
    let file = DatasetFile::read(&args.input)?;
    let overrides = args.scene.after(&args.overrides, &file.capture());
    let set = DataSet::new(sandbox, file, &overrides, args.film_memory)?.on_chosen_device(&args.device, &monitor)?;
    if let Some(samples) = &args.samples {
        set.check_samples(samples)?;
    }
    let count = set.frame_count();
    let (mut numbers, is_more) = args.frames.as_ref().map_or(((0..count).collect(), false), |list| list.among(count));
    if is_more && !args.quiet {
        warning!("--frames names frames that do not exist: the data set has {count}, 0..{count}");
    }
    if let Some(shard) = args.shard {
        numbers = shard.share(numbers);
    }
    let frames = set.frames(numbers, args.keep_going, &monitor)?;
    let default = PathBuf::from(&*args.input.file_stem().unwrap_or_default().to_string_lossy());
    let path = args.output.as_deref().unwrap_or(&default);
    trust(path);
    let options = MakeOptions { keeps_going: args.keep_going, jobs: args.jobs, ..MakeOptions::default() };
    if args.dry_run {
        let forecast = set.forecast(&frames, path, options, &monitor)?;
        return report.forecast(&forecast);
    }
    if !args.keep_going {
        set.check_first(&frames)?;
    }
    let folder = match &args.samples {
        _ if args.index_only => set.open(path)?,
        Some(samples) => set.claim_part(path, samples, &args.input)?,
        None => set.claim(path)?,
    };
    let damaged = if args.verify { set.verify(&frames, &folder, !args.index_only, &monitor)? } else { 0 };
    if args.index_only {
        return report.index(&set, &frames, &folder, damaged);
    }
    let light = |_: &str, _| Ok(args.samples.clone().map_or(LightSource::Traced, LightSource::Part));
    let made = set.make(&frames, &folder, &report.listening(&monitor), options, light)?;
    if args.samples.is_none() {
        return report.finish(&set, &folder, &made);
    }
    // Parts have no summary: they are no images.
    let present = set.present(&folder);
    report.print(&set, &folder, [made.images, present], ["part of an image", "parts of images"], None)?;
    made.check(&folder)
}

/// Way in which the end of a data set is reported.
#[derive(Clone, Copy)]
pub(super) struct SetReport {
    quiet: bool,
    json: bool,
}

impl SetReport {
    pub(super) fn of(quiet: bool, json: bool) -> Self {
        Self { quiet, json }
    }

    /// Monitor that passes everything to `monitor`, and prints a line for each image where that is requested.
    pub(super) fn listening<'a>(self, monitor: &'a dyn Monitor) -> ImageLines<'a> {
        ImageLines { monitor, prints: self.json, counts: Mutex::default() }
    }

    /// Writes the summary of the images, and prints it.
    pub(super) fn finish(self, set: &DataSet, folder: &DatasetFolder, made: &DatasetOutcome) -> Result<()> {
        let index = set.write_index(folder)?;
        if !self.quiet {
            index.left_out.iter().for_each(|why| warning!("calibration/ lacks {}", why.replace('`', "")));
        }
        self.print(set, folder, [made.images, index.present], ["image", "images"], Some(&index.noise))?;
        made.check(folder)
    }

    /// Writes the summary of the images that are there, and compares it with the selection.
    fn index(self, set: &DataSet, frames: &Frames, folder: &DatasetFolder, damaged: usize) -> Result<()> {
        let index = set.write_index(folder)?;
        self.print(set, folder, [0, index.present - damaged], ["image", "images"], Some(&index.noise))?;
        index.check(frames, damaged, folder)
    }

    fn forecast(self, forecast: &Forecast) -> Result<()> {
        if self.json {
            print_json(forecast)?;
        } else {
            say!("{forecast}");
        }
        forecast.check()
    }

    fn print(
        self,
        set: &DataSet,
        folder: &DatasetFolder,
        [made, present]: [usize; 2],
        what: [&str; 2],
        noise: Option<&SetNoise>,
    ) -> Result<()> {
        let (frames, cameras) = (set.frame_count(), set.cameras().count());
        let all = frames as usize * cameras;
        if self.json {
            return println_out(
                &json!({
                    "event": "end",
                    "folder": folder.path(),
                    "frames": frames,
                    "cameras": cameras,
                    "made": made,
                    "present": present,
                    "complete": present == all,
                    "noise_ratio": noise,
                })
                .to_string(),
            );
        }
        if !self.quiet {
            say!("made {}; {present} of {all} are in {}", counted(made, what), folder.path().display());
            if let Some(words) = noise.and_then(SetNoise::in_words) {
                say!("{words}");
            }
        }
        Ok(())
    }
}

/// Monitor that prints a line for each image of a data set, and passes everything on.
pub(super) struct ImageLines<'a> {
    monitor: &'a dyn Monitor,
    prints: bool,
    /// Number of finished images, and of all.
    counts: Mutex<[u64; 2]>,
}

impl Monitor for ImageLines<'_> {
    fn report(&self, event: Event<'_>) {
        self.monitor.report(event);
        if !self.prints {
            return;
        }
        // Lines come out in the order of their numbers.
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let line = match event {
            Event::SetBegins { images } => {
                *counts = [0, images];
                return;
            }
            Event::ImageEnds(Some(ImageOfFrame { camera, frame, made })) => {
                counts[0] += 1;
                let [done, of] = *counts;
                json!({
                    "event": "picture", "camera": camera, "frame": frame, "folder": image_name(camera, frame),
                    "made": made.is_some(), "seconds": made.map(|made| made.seconds), "steps": made.map(|made| made.steps),
                    "done": done, "of": of,
                })
            }
            Event::ImageFails { camera, frame, error } => {
                json!({ "event": "failed", "camera": camera, "frame": frame, "message": error.to_string() })
            }
            Event::Warning(_)
            | Event::TraceBegins { .. }
            | Event::Traced(_)
            | Event::PassEnds { .. }
            | Event::TraceEnds
            | Event::ImageEnds(None)
            | Event::Waiting { .. }
            | Event::SetEnds => return,
        };
        // The work goes on, whether somebody reads it or not.
        let _ = println_out(&line.to_string());
    }

    fn is_cancelled(&self) -> bool {
        self.monitor.is_cancelled()
    }
}
