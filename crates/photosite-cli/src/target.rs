//! `photosite target`: calibration targets as files.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::print::{println_text, refuse_existing};
use photosite_calibration::targets::TargetKind;
use photosite_capture::read_target;
use photosite_core::Result;
use photosite_files::lock::Lock;
use photosite_files::target_file::{target_files, write_target};

const EXAMPLES: &str = "\
Example:
  photosite target chessboard --set squares=[10,7] -o board.pdf";

/// Write a calibration target: to print, or to render.
///
/// The extension of FILE chooses the format: .svg and .pdf are pages in true size (print them at 100 %), .toml is a
/// capture file that photographs the target, .obj (with .mtl) its mesh, .json its points and markers. Sizes are the
/// keys of [[targets]] in a capture file.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct TargetArgs {
    /// Kind of target.
    #[arg(value_parser = kinds())]
    kind: TargetKind,
    /// .svg, .pdf, .toml, .obj or .json.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Change a size or another key of the target, for example --set square_mm=20.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
    /// Overwrite an earlier file.
    #[arg(long)]
    force: bool,
}

/// Parser of the kinds by their names.
fn kinds() -> impl TypedValueParser<Value = TargetKind> {
    let values = TargetKind::ALL.iter().map(|kind| PossibleValue::new(kind.name()).help(kind.summary()));
    PossibleValuesParser::new(values).try_map(|name| {
        let named = TargetKind::ALL.iter().find(|kind| kind.name() == name);
        named.copied().ok_or_else(|| format!("there is no target {name}"))
    })
}

pub(super) fn run(args: &TargetArgs) -> Result<()> {
    target_files(&args.output)?.iter().try_for_each(|path| refuse_existing(path, args.force))?;
    let (description, target) = read_target(args.kind, &args.overrides)?;
    // Some are two files that belong together.
    let _lock = Lock::beside(&args.output)?;
    target_files(&args.output)?.iter().try_for_each(|path| refuse_existing(path, args.force))?;
    write_target(&args.output, &description, &target)?;
    if args.quiet {
        return Ok(());
    }
    let size = target.size_m() * 1e3;
    // Whole micrometres.
    let mm = |x: f64| (x * 1e3).round() / 1e3;
    let (path, kind, points) = (args.output.display(), args.kind.name(), target.points.len());
    println_text(&format!("{path}: {kind}, {} × {} mm, points: {points}", mm(size.x), mm(size.y)))
}
