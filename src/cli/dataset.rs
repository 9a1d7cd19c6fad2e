//! `photosite dataset`: a capture again and again, from other poses, under other conditions.

use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use photosite::dataset::{DataSet, DatasetFolder};
use photosite::pipeline::{FilmMemory, LightSource};
use photosite::{Error, Result, Sandbox};
use serde_json::json;

use super::arguments::parse_range;
use super::log::{say, warning};
use super::monitor::TerminalMonitor;
use super::print::print_json;

/// Render a data set: a capture from many poses, under many conditions, by one camera or a rig.
///
/// Each frame is a folder as `photosite render` makes it, DIR/CAMERA/NUMBER. A data set that was broken off goes on
/// where it stopped when the same command is given again. Several processes and machines can share the work: by the
/// same command in the same folder, where each picture is made by one of them, with frames of their own (--frames) if
/// they like, or each with samples of its own (--samples) in a folder of its own.
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
    /// Trace these samples of every pixel only: from A up to, but without, B. `photosite merge` makes one data set of
    /// the folders of all parts.
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    samples: Option<Range<u32>>,
    /// Change a key of the capture file in all frames, for example --set render.samples_per_pixel=16.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Most memory for the film, GiB: a picture of which it needs more is traced in strips, one after the other.
    #[arg(long, value_name = "GIB", default_value = "4")]
    film_memory: FilmMemory,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print what was made on standard output.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &DatasetArgs, sandbox: &Sandbox) -> Result<()> {
    let set = DataSet::read(sandbox, &args.input, &args.overrides, args.film_memory)?;
    if let Some(samples) = &args.samples {
        set.check_samples(samples)?;
    }
    let numbers = args.frames.clone().unwrap_or(0..set.frame_count());
    if numbers.end > set.frame_count() {
        let message = format!("--frames {}..{}: there are {} frames", numbers.start, numbers.end, set.frame_count());
        return Err(Error::Usage { message, help: Some(format!("write at most 0..{}", set.frame_count()).into()) });
    }
    let frames = set.frames(numbers)?;
    set.check_first(&frames)?;
    let default = PathBuf::from(&*args.input.file_stem().unwrap_or_default().to_string_lossy());
    let path = args.output.as_deref().unwrap_or(&default);
    let (report, monitor) = (SetReport::of(args.quiet, args.json), TerminalMonitor::new(args.quiet, args.json));
    let Some(samples) = &args.samples else {
        let folder = set.claim(path)?;
        let made = set.make(&frames, &folder, &monitor, |_, _| Ok(LightSource::Traced))?;
        return report.finish(&set, &folder, made);
    };
    let folder = set.claim_part(path, samples, &args.input)?;
    let made = set.make(&frames, &folder, &monitor, |_, _| Ok(LightSource::Part(samples.clone())))?;
    // Parts have no summary: they are no images.
    let present = set.present(&folder);
    report.print(&set, &folder, [made, present], "parts of pictures")
}

/// How the end of a data set is reported.
#[derive(Clone, Copy)]
pub(super) struct SetReport {
    quiet: bool,
    json: bool,
}

impl SetReport {
    pub(super) fn of(quiet: bool, json: bool) -> Self {
        Self { quiet, json }
    }

    /// Writes the summary of the images, and prints it.
    pub(super) fn finish(self, set: &DataSet, folder: &DatasetFolder, made: usize) -> Result<()> {
        let (present, left_out) = set.write_index(folder)?;
        if !self.quiet {
            left_out.iter().for_each(|why| warning!("calibration/ is without {}", why.replace('`', "")));
        }
        self.print(set, folder, [made, present], "pictures")
    }

    fn print(self, set: &DataSet, folder: &DatasetFolder, [made, present]: [usize; 2], what: &str) -> Result<()> {
        let (frames, cameras) = (set.frame_count(), set.cameras().count());
        let all = frames as usize * cameras;
        if self.json {
            return print_json(&json!({
                "folder": folder.path(),
                "frames": frames,
                "cameras": cameras,
                "made": made,
                "present": present,
                "complete": present == all,
            }));
        }
        if !self.quiet {
            say!("made {made} {what}; {present} of {all} {what} are in {}", folder.path().display());
        }
        Ok(())
    }
}
