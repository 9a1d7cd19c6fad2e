//! `photosite merge`: parts of a render become one image, parts of a data set one data set.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::dataset::SetReport;
use super::monitor::TerminalMonitor;
use super::render::{finish, finish_again};
use photosite_capture::report::Timings;
use photosite_capture::{Capture, DatasetFile, relative_path};
use photosite_core::{Error, Result, Sandbox};
use photosite_dataset::{DataSet, MakeOptions, PartFolder};
use photosite_pipeline::{Destination, FilmMemory, LightSource, Parts, Request, render_into};

const EXAMPLES: &str = "\
Example:
  photosite merge part-0 part-1 part-2 -o out";

/// Merge parts that were rendered with --samples.
///
/// The parts are folders that `photosite render --samples A..B` or `photosite dataset --samples A..B` filled. The
/// result has the same bytes as one run with all samples. The capture is read again from where it was, for
/// everything that is not traced: sensor noise, development, ground truth. The merge of a data set continues where
/// it stopped.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct MergeArgs {
    /// The folders of all parts, in any order.
    #[arg(required = true, value_name = "DIR")]
    parts: Vec<PathBuf>,
    /// Folder for the results, created where missing.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// The capture file or scene, if it has moved since it was rendered.
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,
    /// Maximum memory for the film, GiB: an image of which it needs more is traced in strips, one after the other.
    #[arg(long, value_name = "GIB", default_value = "4")]
    film_memory: FilmMemory,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Print the contents of capture.json on standard output.
    #[arg(long)]
    json: bool,
    /// Overwrite earlier results.
    #[arg(long)]
    force: bool,
}

impl MergeArgs {
    /// Input of the render: the one given, else the one stated in a part, which must be within the sandbox.
    fn input(&self, stated: &Path, part: &Path, sandbox: &Sandbox) -> Result<PathBuf> {
        let checked = || sandbox.check(stated).map(|()| stated.to_owned());
        self.input.clone().map_or_else(|| checked().map_err(|invalid| invalid.in_file(part)), Ok)
    }
}

pub(super) fn run(args: &MergeArgs, sandbox: &Sandbox) -> Result<()> {
    if args.parts.iter().any(|part| PartFolder::is_one(part)) {
        merge_sets(args, sandbox)
    } else {
        merge_images(args, sandbox)
    }
}

fn merge_images(args: &MergeArgs, sandbox: &Sandbox) -> Result<()> {
    let parts = Parts::read(&args.parts)?;
    let start = Instant::now();
    let part = parts.first();
    let (input, overrides) = (args.input(&part.path, &args.parts[0], sandbox)?, part.overrides.clone());
    let capture = parts.on_their_device(Capture::load_within(sandbox, &input, &overrides)?);
    let timings = Timings { load_s: start.elapsed().as_secs_f64(), ..Timings::default() };
    let is_timed = parts.trace_s().is_some();
    let light = LightSource::Merged(parts);
    let monitor = &TerminalMonitor::new(args.quiet, args.json);
    let mut folder = match Destination::claim(&args.output, args.force, &capture, &light, monitor)? {
        Destination::Free(folder) => folder,
        Destination::Done(rendered) => return finish_again(&rendered, &args.output, args.quiet, args.json),
    };
    let request = Request {
        input: &input,
        named: relative_path(&input, folder.path()),
        is_timed,
        light,
        film_memory: args.film_memory,
        monitor,
    };
    let rendered = render_into(capture, &request, &mut folder, timings)?;
    finish(&rendered, folder.path(), args.quiet, args.json)
}

fn merge_sets(args: &MergeArgs, sandbox: &Sandbox) -> Result<()> {
    if args.force {
        let message = "--force: a data set continues where it stopped, and nothing is overwritten".to_owned();
        return Err(Error::Usage { message, help: Some("remove --force, or choose another folder with -o".into()) });
    }
    let parts = args.parts.iter().map(|path| PartFolder::read(path)).collect::<Result<Vec<_>>>()?;
    let input = args.input(&parts[0].input(), &args.parts[0], sandbox)?;
    let set = DataSet::new(sandbox, DatasetFile::read(&input)?, &parts[0].arguments(), args.film_memory)?;
    let set = set.on_device(parts[0].device());
    let (report, monitor) = (SetReport::of(args.quiet, args.json), TerminalMonitor::new(args.quiet, args.json));
    let frames = set.frames(0..set.frame_count(), false, &monitor)?;
    let listening = report.listening(&monitor);
    let (folder, made) = set.merge(&parts, &frames, &args.output, &listening, MakeOptions::default())?;
    report.finish(&set, &folder, &made)
}
