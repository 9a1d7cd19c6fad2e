//! The command line: one file a subcommand. Arguments come in here, results and errors go out; the work is the
//! library's.

mod camera;
mod compare;
mod compare_report;
mod dataset;
mod develop;
mod develop_args;
mod emva1288;
mod emva1288_report;
mod export_mitsuba;
mod expose;
mod figures_text;
mod film_memory;
mod info;
mod layout;
mod listing;
mod log;
mod measure;
mod merge;
mod merge_hdr;
mod monitor;
mod noise;
mod project;
mod render;
mod run_args;
mod schema;
mod sensors;
mod signals;
mod target;

use std::io::IsTerminal;
use std::ops::Range;
use std::path::Path;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use photosite::io::output::{Sink, write_new, write_whole};
use photosite::io::pretty_json::pretty_json;
use photosite::{Error, Remedy};

/// What scripts and schedulers go by.
const EXIT_STATUS: &str = "\
Exit status: 0 done; 1 failed, or pictures differ; 2 wrong usage; 75 failed, but another try may succeed (disk full, a server or
a file went away, another process writes to the same place); 129, 130, 143 ended by SIGHUP, SIGINT, SIGTERM, after which a
render goes on from its checkpoint when the same command is given again.";

/// Renders glTF and OBJ scenes as a camera would record them: photons, electrons, raw files.
#[derive(Parser)]
#[command(version, about, max_term_width = 100, after_help = EXIT_STATUS)]
struct Cli {
    /// Write what is said on standard error as JSON, an object per line: `time_s`, `event` (warning, progress, message, error
    /// …) and what belongs to it.
    #[arg(long, global = true)]
    log_json: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Render(render::RenderArgs),
    Develop(develop::DevelopArgs),
    Expose(expose::ExposeArgs),
    Compare(compare::CompareArgs),
    Measure(measure::MeasureArgs),
    Merge(merge::MergeArgs),
    MergeHdr(merge_hdr::MergeHdrArgs),
    Dataset(dataset::DatasetArgs),
    Layout(layout::LayoutArgs),
    ExportMitsuba(export_mitsuba::ExportMitsubaArgs),
    #[command(name = "emva1288")]
    Emva1288(emva1288::Emva1288Args),
    #[command(name = "emva1288-report")]
    Emva1288Report(emva1288_report::Emva1288ReportArgs),
    Info(info::InfoArgs),
    Noise(noise::NoiseArgs),
    Project(project::ProjectArgs),
    Camera(camera::CameraArgs),
    Sensors(sensors::SensorsArgs),
    Schema(schema::SchemaArgs),
    Target(target::TargetArgs),
}

/// Runs the command line of this process, with the exit status that [`EXIT_STATUS`] tells of.
pub(crate) fn run() -> ExitCode {
    let cli = Cli::parse();
    signals::listen();
    if cli.log_json {
        log::speak_json();
    }
    // Colours, arrows and short lines are for people; a log file gets plain text, to be searched line by line.
    let fancy = std::io::stderr().is_terminal();
    let handler = move |_: &_| -> Box<dyn miette::ReportHandler> {
        let options = miette::MietteHandlerOpts::new().color(fancy).unicode(fancy);
        Box::new(options.wrap_lines(fancy).break_words(false).build())
    };
    // Fails only if a handler was set before, and this is the only place that sets one.
    let _ = miette::set_hook(Box::new(handler));
    let mut done = ExitCode::SUCCESS;
    let outcome = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Develop(args) => develop::run(&args),
        Command::Expose(args) => expose::run(&args),
        Command::Compare(args) => compare::run(&args).map(|status| done = status),
        Command::Measure(args) => measure::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::MergeHdr(args) => merge_hdr::run(&args),
        Command::Dataset(args) => dataset::run(&args),
        Command::Layout(args) => layout::run(&args),
        Command::ExportMitsuba(args) => export_mitsuba::run(&args),
        Command::Emva1288(args) => emva1288::run(&args),
        Command::Emva1288Report(args) => emva1288_report::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Noise(args) => noise::run(&args),
        Command::Project(args) => project::run(&args),
        Command::Camera(args) => camera::run(&args),
        Command::Sensors(args) => sensors::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Target(args) => target::run(&args),
    };
    match outcome {
        Ok(()) => done,
        Err(error) => {
            let status = status(&error);
            // Who asked the work to stop, the program alone knows.
            let error = match error {
                Error::Cancelled { help, .. } => Error::Cancelled { message: signals::stopped_by().to_owned(), help },
                error @ (Error::Input(_)
                | Error::Io { .. }
                | Error::Override { .. }
                | Error::Usage { .. }
                | Error::Temporary(_)) => error,
            };
            let error = error.in_words(&in_options, "--set");
            log::error(error, status);
            ExitCode::from(status)
        }
    }
}

fn status(error: &Error) -> u8 {
    /// EX_TEMPFAIL of sysexits.h.
    const ANOTHER_TRY: u8 = 75;
    match error {
        Error::Cancelled { .. } => signals::status(),
        Error::Override { .. } | Error::Usage { .. } => 2,
        Error::Input(_) | Error::Io { .. } | Error::Temporary(_) if error.is_temporary() => ANOTHER_TRY,
        Error::Input(_) | Error::Io { .. } | Error::Temporary(_) => 1,
    }
}

/// What to do about an error, as the options of the command line that do it.
fn in_options(remedy: &Remedy) -> String {
    match remedy {
        Remedy::Say(words) => words.clone(),
        Remedy::Overwrite => "add --force to overwrite".to_owned(),
        Remedy::StartAnew => "add --force to start anew".to_owned(),
        Remedy::Elsewhere(place) => format!("choose {place} with -o"),
        Remedy::Override(change) => format!("add --set {change}"),
        Remedy::Example(change) => format!("for example --set {change}"),
        Remedy::FilmMemory(gib) => format!("add --film-memory {gib}"),
        Remedy::Samples([from, to]) => format!("render them with --samples {from}..{to}"),
        Remedy::Channels(names) => format!("name channels that both have: --channels {}", names.join(",")),
        Remedy::Masked { name, area } => {
            format!("of {name} the active area is looked at, {area}; --masked looks at its masked pixels, too")
        }
        Remedy::Nearest => "add --approximate for the nearest that Mitsuba has".to_owned(),
        Remedy::Linear => "say --linear where its codes are in proportion to light".to_owned(),
    }
}

/// Starts as many threads as are asked for.
fn start_threads(threads: Option<u16>) -> photosite::Result<()> {
    /// So many that wait for each other slow down a small machine only a little.
    const MOST: usize = 256;
    let Some(threads) = threads.map(usize::from) else { return Ok(()) };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let usage = |message: String| Error::Usage {
        message,
        help: Some(format!("this machine runs {cores} at once; more than these make nothing faster").into()),
    };
    if threads > MOST.max(4 * cores) {
        return Err(usage(format!("--threads {threads}: at most {} can be asked for", MOST.max(4 * cores))));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    pool.map_err(|reason| usage(format!("cannot start {threads} threads: {reason}")))
}

/// A range of whole numbers as arguments have it, `A..B`: from A up to, but without, B.
fn parse_range(text: &str) -> Result<Range<u32>, String> {
    let number = |part: &str| part.trim().parse::<u32>().ok();
    let ends = text.split_once("..").and_then(|(a, b)| Some((number(a)?, number(b)?)));
    match ends {
        Some((a, b)) if a < b => Ok(a..b),
        Some(_) => Err("the first number must be below the second".to_owned()),
        None => Err("write two whole numbers, for example 0..10".to_owned()),
    }
}

/// Significant digits, few enough for people.
fn rounded(x: f64, digits: i32) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let scale = 10f64.powf(f64::from(digits - 1) - x.abs().log10().floor());
    if scale.is_finite() && scale > 0.0 { (x * scale).round() / scale } else { x }
}

/// Refuses to overwrite a file unasked.
fn refuse_existing(path: &Path, force: bool) -> photosite::Result<()> {
    if force || !path.exists() { Ok(()) } else { Err(exists_already(path)) }
}

fn exists_already(path: &Path) -> Error {
    let message = format!("{} exists already", path.display());
    Error::Usage { message, help: Some("add --force to overwrite it, or choose another name".into()) }
}

/// Writes a file whole. One that another process has put there in the meantime is not overwritten unasked, either.
fn write_result(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut dyn Sink) -> std::io::Result<()>,
) -> photosite::Result<()> {
    if force {
        write_whole(path, write)
    } else if write_new(path, write)? {
        Ok(())
    } else {
        Err(exists_already(path))
    }
}

/// Prints an object as JSON on standard output.
fn print_json(value: &impl serde::Serialize) -> photosite::Result<()> {
    println_out(&pretty_json(value))
}

/// Prints a line on standard output. A reader that has seen enough and went away, as `head` does, is no error.
fn println_out(text: &str) -> photosite::Result<()> {
    use std::io::{ErrorKind, Write};
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::io("standard output".as_ref(), "write", error))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}
