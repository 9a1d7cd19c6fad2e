//! `photosite emva1288-report`: the figures of image sets, measured and expected.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde_json::json;

use super::figures_text::{measured_text, paired_text};
use super::monitor::TerminalMonitor;
use super::print::{print_json, println_text, refuse_existing, write_result};
use photosite_capture::FileKind;
use photosite_core::Result;
use photosite_dataset::emva1288::{MeasuredChannel, evaluate_descriptor, evaluate_sets};
use photosite_measure::characterisation::report::{PairReport, PairedFigure};

const EXAMPLES: &str = "\
Examples:
  photosite emva1288-report emva1288-sony-imx249-mono
  photosite emva1288-report camera twin          two sets side by side";

/// Evaluate EMVA 1288 image sets, as text and an HTML page.
///
/// A descriptor lists the images with their conditions: "n 12 640 480" for bits, columns and rows, "b 20000000 1234.5"
/// for exposure time in ns and photons per pixel before bright images, "d 20000000" before dark ones, "i images\a.tif"
/// for each. Where exposure times are unknown and stated as 0, figures that depend on them are left out and named.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Emva1288ReportArgs {
    /// A folder that photosite emva1288 filled, or a descriptor of images of any camera (.txt).
    input: PathBuf,
    /// Another set, to stand beside the first: each figure with its difference in standard errors.
    #[arg(value_name = "OTHER")]
    other: Option<PathBuf>,
    /// The page [default: report.html in the folder, comparison.html for two sets].
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
    let folder = if args.input.is_dir() { &*args.input } else { args.input.parent().unwrap_or(Path::new("")) };
    let page = if args.other.is_some() { "comparison.html" } else { "report.html" };
    let output = args.output.clone().unwrap_or_else(|| folder.join(page));
    refuse_existing(&output, args.force)?;
    let inputs = [Some(&args.input), args.other.as_ref()];
    for input in inputs.into_iter().flatten() {
        FileKind::expect(input, &[], "a folder of image sets or a descriptor of images (.txt)")?;
    }
    let monitor = TerminalMonitor::new(args.quiet, args.json);
    let evaluated = |input: &Path| match input.is_dir() {
        true => evaluate_sets(input, &monitor),
        false => evaluate_descriptor(input, &monitor),
    };
    let report = evaluated(&args.input)?;
    if let Some(other) = &args.other {
        let sets = [(&args.input, report), (other, evaluated(other)?)].map(|(path, report)| (name(path), report));
        let pair = PairReport::new(sets).map_err(|invalid| invalid.in_file(other))?;
        return print_pair(args, &pair, &output);
    }
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

/// Figure of two sets, for programs.
#[derive(Serialize)]
struct PairedObject {
    figure: &'static str,
    symbol: &'static str,
    unit: &'static str,
    first: Option<f64>,
    second: Option<f64>,
    difference: Option<f64>,
    /// Difference in standard errors; null where the images do not tell these.
    standard_errors: Option<f64>,
}

impl From<PairedFigure> for PairedObject {
    fn from(PairedFigure { first, second, difference, in_errors }: PairedFigure) -> Self {
        let (figure, symbol, unit) = (first.name, first.symbol, first.unit);
        Self { figure, symbol, unit, first: first.value, second, difference, standard_errors: in_errors }
    }
}

fn print_pair(args: &Emva1288ReportArgs, pair: &PairReport, output: &Path) -> Result<()> {
    write_result(output, args.force, |to| to.write_all(pair.html().as_bytes()))?;
    if args.json {
        let channels = pair.channels().map(|(title, figures)| {
            let figures: Vec<PairedObject> = figures.into_iter().map(PairedObject::from).collect();
            json!({ "channel": title, "figures": figures })
        });
        print_json(&channels.collect::<Vec<_>>())
    } else if args.quiet {
        Ok(())
    } else {
        println_text(&paired_text(pair))?;
        println_text(&format!("\nthe curves are in {}", output.display()))
    }
}

/// Name of a set in tables and legends.
fn name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}
