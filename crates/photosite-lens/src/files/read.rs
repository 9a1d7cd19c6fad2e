//! Reading of lens files, from bytes to a lens.

use std::path::Path;

use photosite_core::{Error, Invalid, json};

use super::draft::{Draft, Fault, Read};
use super::format::Format;
use super::report::Reading;
use super::seq::FirstNumber;
use super::{deeplens, finish, json_value, neutral, optical_bench, optiland, pbrt, rayoptics, seq, text, zmx};

/// Reads a lens file.
///
/// # Errors
///
/// Faults, with the line and the surface: a value that cannot be used, a glass or a kind of surface that is not known,
/// a lens that makes no image.
pub fn read(bytes: &[u8], path: &Path) -> photosite_core::Result<Reading> {
    read_with(bytes, path, None)
}

/// Reads a lens file. `first_number` gives the meaning of the first number of each surface where a CODE V sequence has
/// no RDM.
///
/// # Errors
///
/// Errors of [`read`], and `first_number` given for a file of a format that says it itself.
pub fn read_with(bytes: &[u8], path: &Path, first_number: Option<FirstNumber>) -> photosite_core::Result<Reading> {
    let text = text::decoded(bytes).map_err(|invalid| invalid.in_file(path))?;
    let format = Format::of(path, &text).map_err(|invalid| invalid.in_file(path))?;
    if first_number.is_some() && format != Format::Seq {
        let message = format!("{} says itself whether it has radii or curvatures", format.name());
        return Err(Invalid::new("", message).help("leave --radii and --curvatures to CODE V's .seq").in_file(path));
    }
    drafted(format, &text, first_number)
        .and_then(|draft| finish::finish(format, draft))
        .map_err(|fault| placed(fault, format, path, &text))
}

fn drafted(format: Format, text: &str, first_number: Option<FirstNumber>) -> Read<Draft> {
    match format {
        Format::Toml => neutral::read_toml(text),
        Format::Json => neutral::read_json(text),
        Format::Zmx => zmx::read(text),
        Format::Seq => seq::read(text, first_number),
        Format::OpticalBench => optical_bench::read(text),
        Format::Pbrt => pbrt::read(text),
        Format::Optiland => json_value::parsed(text).and_then(|value| optiland::read(&value)),
        Format::RayOptics => json_value::parsed(text).and_then(|value| rayoptics::read(&value)),
        Format::DeepLens => json_value::parsed(text).and_then(|value| deeplens::read(&value)),
    }
}

/// Error of a fault, with its file and the line of its key.
fn placed(fault: Fault, format: Format, path: &Path, text: &str) -> Error {
    let Fault { line, invalid } = fault;
    match (line, format) {
        (Some(line), _) => invalid.at_line(path, line),
        (None, Format::Toml) => match neutral::toml_span(text, &invalid.key) {
            Some(span) => invalid.in_text(path, text, span),
            None => invalid.in_file(path),
        },
        (None, Format::Json | Format::Optiland | Format::RayOptics | Format::DeepLens) => {
            json::located(invalid, path, json_value::with_words_quoted(text).as_bytes())
        }
        (None, Format::Zmx | Format::Seq | Format::OpticalBench | Format::Pbrt) => invalid.in_file(path),
    }
}
