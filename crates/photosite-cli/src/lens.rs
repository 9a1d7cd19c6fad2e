//! `photosite lens`: figures of a lens from a prescription.

use std::path::{Path, PathBuf};

use clap::Args;
use photosite_core::{input, suggest};
use photosite_lens::files::{self, FirstNumber, Reading};

use super::log::warning;
use super::print::{print_json, println_out, println_text, refuse_existing, write_result};
use crate::lens_figures::{LensFigures, Options, ShippedLens, html, shipped_lenses};
use photosite_capture::FileKind;
use photosite_core::{Error, Invalid, Result};

/// Largest size of a lens file, bytes.
const MOST_BYTES: u64 = 4 << 20;

const EXAMPLES: &str = "\
Examples:
  photosite lens double-gauss
  photosite lens zoom-laikin --position 2
  photosite lens patent.zmx --f-number 4 -o lens.toml -o lens.html";

/// Show what a lens does: focal length, distortion, MTF …
///
/// Values that a file does not state, and entries that are not used, are listed.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct LensArgs {
    #[arg(required_unless_present = "list", help = format!(
        "A lens file of {}, or the name of one that ships with photosite: double-gauss, canon-ef50 and others",
        files::formats()
    ))]
    lens: Option<PathBuf>,
    /// Write the lens in photosite's own form (.toml), or a page about it (.html): cross-section with rays, field
    /// curves, spots, modulation transfer.
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Close the stop to this f-number [default: open].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    f_number: Option<f64>,
    /// Half of the angle of view, degrees [default: that of the file].
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    half_field: Option<f64>,
    /// The position of zoom and focus to show, by its label or its number from 1 on [default: all].
    #[arg(long, value_name = "POSITION")]
    position: Option<String>,
    /// In a CODE V .seq without RDM, the first number of each surface is its radius.
    #[arg(long)]
    radii: bool,
    /// In a CODE V .seq without RDM, the first number of each surface is its curvature, 1/R.
    #[arg(long, conflicts_with = "radii")]
    curvatures: bool,
    /// Overwrite the output if it exists.
    #[arg(long)]
    force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
    /// Print nothing but warnings and errors.
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
    /// List the lenses that ship with photosite, with focal length and f-number.
    #[arg(long, exclusive = true)]
    list: bool,
}

pub(super) fn run(args: &LensArgs) -> Result<()> {
    let Some(lens) = &args.lens else {
        return list();
    };
    args.output.iter().try_for_each(|output| refuse_existing(output, args.force))?;
    let kinds = args.output.iter().map(|output| kind(output)).collect::<Result<Vec<_>>>()?;
    let first_number = match (args.radii, args.curvatures) {
        (true, _) => Some(FirstNumber::Radius),
        (false, true) => Some(FirstNumber::Curvature),
        (false, false) => None,
    };
    let reading = reading(lens, first_number)?;
    for words in &reading.report.warnings {
        warning!("{}: {words}", lens.display());
    }
    let options = Options { is_text: !args.json && !kinds.contains(&Kind::Page), ..options(args)? };
    // The file of ours takes no figures.
    let needs_figures = !args.quiet || kinds.contains(&Kind::Page);
    let figures = if needs_figures { Some(LensFigures::new(&reading, &options)?) } else { None };
    for (output, kind) in args.output.iter().zip(kinds) {
        let text = match (kind, &figures) {
            (Kind::Page, Some(figures)) => html(&reading, figures),
            (Kind::Prescription | Kind::Page, _) => files::to_toml(&reading.prescription),
        };
        write_result(output, args.force, |to| to.write_all(text.as_bytes()))?;
    }
    if let Some(lost) = figures.as_ref().and_then(LensFigures::lost) {
        warning!("{}: {lost}", lens.display());
    }
    match figures {
        Some(figures) if args.json => print_json(&figures),
        Some(figures) if !args.quiet => println_text(&figures.text()),
        Some(_) | None => Ok(()),
    }
}

/// Prints the lenses that ship, one per line.
fn list() -> Result<()> {
    let lenses = shipped_lenses()?;
    let width = lenses.iter().map(|lens| lens.name.len()).max().unwrap_or(0);
    // One number, or that of both ends of a zoom.
    let range = |[least, most]: [f64; 2], digits| {
        let [least, most] = [least, most].map(|x| format!("{x:.digits$}"));
        if least == most { least } else { format!("{least}–{most}") }
    };
    let line = |lens: &ShippedLens| {
        let (length, number) = (range(lens.focal_length_mm, 1), range(lens.f_number, 2));
        format!("{:width$}  {length:>15}  {number:>9}  {}", lens.name, lens.description)
    };
    let head = format!("{:width$}  {:>15}  {:>9}  lens", "name", "focal length mm", "f-number");
    println_out(&[vec![head], lenses.iter().map(line).collect()].concat().join("\n"))
}

/// Kind of output.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Prescription,
    Page,
}

fn kind(output: &Path) -> Result<Kind> {
    match output.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase().as_str() {
        "toml" => Ok(Kind::Prescription),
        "html" | "htm" => Ok(Kind::Page),
        other => Err(Error::Usage {
            message: format!("{}: a lens cannot be written as {other:?}", output.display()),
            help: Some(
                "write to a .toml file, which is the lens in photosite's own form, or to .html, its page".into(),
            ),
        }),
    }
}

/// Reads a lens file, or the lens that ships under this name.
fn reading(lens: &Path, first_number: Option<FirstNumber>) -> Result<Reading> {
    let name = lens.to_string_lossy();
    if !lens.exists()
        && let Some(shipped) = files::shipped(&name)
    {
        return match first_number {
            None => Ok(shipped),
            Some(_) => Err(Error::Usage {
                message: "--radii and --curvatures are for a .seq file without RDM".to_owned(),
                help: Some(format!("leave them out: {name} says itself what its numbers are").into()),
            }),
        };
    }
    if !lens.exists() && lens.extension().is_none() {
        let near = suggest::did_you_mean(&name, files::names());
        let message = format!("there is neither a file nor a lens {name:?}{near}");
        let help = format!("name a lens file, or one of {}", suggest::list(&name, files::names()));
        return Err(Error::Usage { message, help: Some(help.into()) });
    }
    // Lenses have JSON files, too.
    FileKind::expect(lens, &[FileKind::Lens, FileKind::Report], "a lens file")?;
    let bytes = input::read_at_most(lens, MOST_BYTES).map_err(|reason| Error::io(lens, "read", reason))?;
    files::read_with(&bytes, lens, first_number)
}

fn options(args: &LensArgs) -> Result<Options> {
    if let Some(angle) = args.half_field.filter(|angle| !(*angle > 0.0 && *angle < 120.0)) {
        let invalid =
            Invalid::new("--half-field", format!("{angle}° is not a half field")).help("write an angle above 0°");
        return Err(Error::Usage { message: invalid.to_string(), help: invalid.help });
    }
    let (f_number, position) = (args.f_number, args.position.clone());
    Ok(Options { f_number, half_field_deg: args.half_field, position, is_text: false })
}
