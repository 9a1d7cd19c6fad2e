//! The command line, for the program `photosite` and for the Python package, which has the same command: one file per
//! subcommand. Arguments come in here, results and errors go out; the work is done by other crates, none of which
//! depends on this one.

#![forbid(unsafe_code)]

mod arguments;
mod camera;
mod compare;
mod compare_report;
mod completions;
mod dataset;
mod depth;
mod develop;
mod develop_args;
mod devices;
mod emva1288;
mod emva1288_report;
mod exit_status;
mod export_mitsuba;
mod expose;
mod figures_text;
mod file_args;
mod fit;
mod help;
mod info;
mod init;
mod isetcam;
mod json_text;
mod layout;
mod lens;
mod lens_figures;
mod log;
mod man;
mod measure;
mod measured_edges;
mod merge;
mod merge_hdr;
mod monitor;
mod noise;
mod noise_add;
mod noise_model;
mod noise_series;
mod print;
mod project;
mod rectify;
mod remedies;
mod render;
mod run_args;
mod scene_args;
mod schema;
mod sensitivities;
mod sensors;
mod shell_words;
mod shorthands;
mod signals;
mod status;
mod target;
#[cfg(test)]
mod tests;
#[cfg(feature = "view")]
mod view;

use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};

use self::arguments::start_threads;
use self::exit_status::{ANOTHER_TRY, DONE, FAILED, WRONG_USAGE};
use self::remedies::in_options;
use photosite_core::sandbox::check_refused;
use photosite_core::{Error, Result, Sandbox, memory};
use photosite_pipeline::cache;

/// Heading of the options that all commands have, which come last in their help.
const EVERYWHERE: &str = "Options of every command";

/// Renders glTF, OBJ, PLY and STL scenes as a camera would record them: photons, electrons, raw files.
#[derive(Parser)]
#[command(name = "photosite", version, about, long_about = None, max_term_width = 80)]
struct Cli {
    /// Threads to use [default: all cores].
    #[arg(long, global = true, value_name = "N", help_heading = EVERYWHERE, allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Maximum memory to use, GiB; what needs more is refused [default: what is free, and what cgroups allow].
    #[arg(long, global = true, value_name = "GIB", help_heading = EVERYWHERE, allow_negative_numbers = true)]
    memory: Option<f64>,
    /// Refuse files outside this folder, whether captures name them or links lead there: for files that you do not
    /// trust. What the command line names is trusted.
    #[arg(long, global = true, value_name = "DIR", help_heading = EVERYWHERE)]
    sandbox: Option<PathBuf>,
    /// Write messages on standard error as JSON, one object per line: `time_s`, `event` (warning, progress, message,
    /// error …) and what belongs to it.
    #[arg(long, global = true, help_heading = EVERYWHERE)]
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
    Status(status::StatusArgs),
    Layout(layout::LayoutArgs),
    Lens(lens::LensArgs),
    Rectify(rectify::RectifyArgs),
    Depth(depth::DepthArgs),
    ExportMitsuba(export_mitsuba::ExportMitsubaArgs),
    #[command(name = "emva1288")]
    Emva1288(emva1288::Emva1288Args),
    #[command(name = "emva1288-report")]
    Emva1288Report(emva1288_report::Emva1288ReportArgs),
    Fit(fit::FitArgs),
    Info(info::InfoArgs),
    Init(init::InitArgs),
    Noise(noise::NoiseArgs),
    Project(project::ProjectArgs),
    Camera(camera::CameraArgs),
    Sensors(sensors::SensorsArgs),
    Schema(schema::SchemaArgs),
    Target(target::TargetArgs),
    #[cfg(feature = "view")]
    View(view::ViewArgs),
    Devices(devices::DevicesArgs),
    Completions(completions::CompletionsArgs),
    Man(man::ManArgs),
}

/// Command with all its subcommands, from which help, completions and manual pages are made.
fn command() -> clap::Command {
    help::grouped(Cli::command())
}

/// Runs a command line, whose first argument is the name of the program, and returns the exit status.
///
/// The function is for a process that does nothing else, and is called once: it starts rayon's global threads, listens
/// to signals, and ends the process where one comes while the work under way cannot be kept.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let found = command().try_get_matches_from(&arguments);
    let parsed = found.and_then(|found| Cli::from_arg_matches(&found).map(|cli| (cli, named_files(&found))));
    let status = match parsed {
        Ok((cli, named)) => run_parsed(&cli, named),
        // Wrong usage, or what --help and --version ask for.
        Err(words) => {
            let words = help::unknown_option(words, &command(), &arguments);
            let _ = words.print();
            if words.use_stderr() { WRONG_USAGE } else { DONE }
        }
    };
    // Of a process that is not Rust's nobody else does so in the end.
    let _ = std::io::stdout().flush();
    status
}

/// Files and folders that a command line names itself.
fn named_files(found: &ArgMatches) -> Vec<PathBuf> {
    let of_option = |id: &clap::Id| found.try_get_many::<PathBuf>(id.as_str()).ok().flatten();
    let own = found.ids().filter_map(of_option).flatten().cloned();
    own.chain(found.subcommand().map(|(_, below)| named_files(below)).unwrap_or_default()).collect()
}

fn run_parsed(cli: &Cli, named: Vec<PathBuf>) -> u8 {
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
    match run_command(cli, named) {
        Ok(status) => status,
        Err(mut error) => {
            let status = status(&error);
            // Who asked the work to stop, the program alone knows.
            if let Error::Cancelled { message, .. } = &mut error {
                signals::stopped_by().clone_into(message);
            }
            let error = error.in_words(&in_options, "--set");
            log::error(error, status);
            status
        }
    }
}

/// Runs a command, with the threads and the memory that it is given.
fn run_command(cli: &Cli, named: Vec<PathBuf>) -> Result<u8> {
    cli.memory.map_or(Ok(()), memory::set_limit)?;
    cache::keep_on_disk();
    let sandbox = &cli.sandbox.as_deref().map_or_else(|| Ok(Sandbox::default()), Sandbox::new)?;
    sandbox.confine(named);
    start_threads(cli.threads)?;
    signals::listen()?;
    let done = run_subcommand(cli, sandbox);
    // What is only looked for is done without where it is refused, and what fails then fails of that.
    check_refused().and(done)
}

fn run_subcommand(cli: &Cli, sandbox: &Sandbox) -> Result<u8> {
    let done = match &cli.command {
        Command::Render(args) => render::run(args, sandbox),
        Command::Develop(args) => develop::run(args),
        Command::Expose(args) => expose::run(args, sandbox),
        Command::Compare(args) => return compare::run(args).map(|agree| if agree { DONE } else { FAILED }),
        Command::Measure(args) => measure::run(args, sandbox),
        Command::Merge(args) => merge::run(args, sandbox),
        Command::MergeHdr(args) => merge_hdr::run(args),
        Command::Dataset(args) => dataset::run(args, sandbox),
        Command::Status(args) => return status::run(args),
        Command::Layout(args) => layout::run(args, sandbox),
        Command::Lens(args) => lens::run(args),
        Command::Rectify(args) => rectify::run(args, sandbox),
        Command::Depth(args) => depth::run(args),
        Command::ExportMitsuba(args) => export_mitsuba::run(args, sandbox),
        Command::Emva1288(args) => emva1288::run(args, sandbox),
        Command::Emva1288Report(args) => emva1288_report::run(args),
        Command::Fit(args) => fit::run(args),
        Command::Info(args) => info::run(args, sandbox),
        Command::Init(args) => init::run(args, sandbox),
        Command::Noise(args) => noise::run(args, sandbox),
        Command::Project(args) => project::run(args, sandbox),
        Command::Camera(args) => camera::run(args, sandbox),
        Command::Sensors(args) => sensors::run(args),
        Command::Schema(args) => schema::run(args),
        Command::Target(args) => target::run(args),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(args, sandbox),
        Command::Devices(args) => devices::run(args),
        Command::Completions(args) => completions::run(args, command()),
        Command::Man(args) => man::run(args, command()),
    };
    done.map(|()| DONE)
}

fn status(error: &Error) -> u8 {
    match error {
        Error::Cancelled { .. } => signals::status(),
        Error::Override { .. } | Error::Usage { .. } => WRONG_USAGE,
        Error::Input(_) | Error::Io { .. } | Error::Temporary(_) if error.is_temporary() => ANOTHER_TRY,
        Error::Input(_) | Error::Io { .. } | Error::Resources { .. } | Error::Temporary(_) => FAILED,
    }
}
