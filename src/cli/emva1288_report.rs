//! `photosite emva1288-report`: the figures that image sets show, against those that they are expected to show.

use std::path::{Path, PathBuf};

use clap::Args;

use super::figures_text::measured_text;
use super::monitor::TerminalMonitor;
use super::print::{print_json, println_text, refuse_existing, write_result};
use crate::Result;
use crate::capture::FileKind;
use crate::emva1288::{MeasuredChannel, evaluate_descriptor, evaluate_sets};

const EXAMPLES: &str = "\
Example:
  photosite emva1288-report emva1288-sony-imx249-mono";

/// Evaluate EMVA 1288 image sets, as text and an HTML page.
///
/// A descriptor names the images and says what they show: "n 12 640 480" for bits, columns and rows, "b 20000000
/// 1234.5" for exposure time in ns and photons per pixel before bright images, "d 20000000" before dark ones, "i
/// images\a.tif" for each. Where exposure times are unknown and stated as 0, what depends on them is left out and
/// named.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Emva1288ReportArgs {
    /// A folder that photosite emva1288 filled, or a descriptor of images of any camera (.txt).
    input: PathBuf,
    /// The page [default: report.html in the folder].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Overwrite the page if it exists.
    #[arg(long)]
    force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors.
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

pub(super) fn run(args: &Emva1288ReportArgs) -> Result<()> {
    let is_folder = args.input.is_dir();
    let folder = if is_folder { &*args.input } else { args.input.parent().unwrap_or(Path::new("")) };
    let output = args.output.clone().unwrap_or_else(|| folder.join("report.html"));
    refuse_existing(&output, args.force)?;
    FileKind::expect(&args.input, &[], "a folder of image sets or a descriptor of images (.txt)")?;
    let monitor = TerminalMonitor::new(args.quiet, args.json);
    let report = if is_folder { evaluate_sets(folder, &monitor)? } else { evaluate_descriptor(&args.input, &monitor)? };
    write_result(&output, args.force, |to| to.write_all(report.html().as_bytes()))?;
    if args.json {
        print_json(&report.channels.iter().map(MeasuredChannel::new).collect::<Vec<_>>())
    } else if args.quiet {
        Ok(())
    } else {
        println_text(&measured_text(&report))?;
        println_text(&format!("\nthe curves are in {}", output.display()))
    }
}
