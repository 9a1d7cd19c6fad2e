//! Files of lenses: our own form, and those of six optical programs, read into the neutral [`Prescription`], with a report
//! of what was read, assumed and ignored.
//!
//! Nothing here touches a disk: readers get bytes, and the path only for messages and for what its ending says of the
//! format.

mod beam;
mod draft;
mod finish;
mod json_value;
mod neutral;
mod optical_bench;
mod optiland;
mod pbrt;
mod rayoptics;
mod report;
mod sanity;
mod seq;
mod shipped;
mod text;
mod write;
mod zmx;

use std::path::Path;

use photosite_core::{Error, Invalid, json};

use self::draft::{Draft, Fault, Read, Row};
use crate::Lens;
use crate::prescription::Prescription;

pub use self::report::{GlassOf, Report};
pub use self::shipped::{names, shipped};
pub use self::write::to_toml;
pub use crate::checks::MOST_SURFACES;

/// Most settings of a zoom or of the focus.
const MOST_POSITIONS: usize = 50;

/// What a lens file is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Our own form as TOML.
    Toml,
    /// Our own form as JSON.
    Json,
    /// OpticStudio (Zemax), `.zmx`.
    Zmx,
    /// CODE V, `.seq`.
    Seq,
    /// The text of the Optical Bench.
    OpticalBench,
    /// pbrt's realistic camera, `.dat`.
    Pbrt,
    /// Optiland's JSON.
    Optiland,
    /// ray-optics, `.roa`.
    RayOptics,
}

impl Format {
    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Toml => "photosite TOML",
            Self::Json => "photosite JSON",
            Self::Zmx => "OpticStudio (.zmx)",
            Self::Seq => "CODE V (.seq)",
            Self::OpticalBench => "Optical Bench",
            Self::Pbrt => "pbrt (.dat)",
            Self::Optiland => "Optiland JSON",
            Self::RayOptics => "ray-optics (.roa)",
        }
    }

    /// The format of a file, by the ending of its name, and for JSON and texts by what is in it.
    fn of(path: &Path, text: &str) -> Result<Self, Invalid> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match ending.as_str() {
            "toml" => Ok(Self::Toml),
            "zmx" => Ok(Self::Zmx),
            "seq" => Ok(Self::Seq),
            "dat" => Ok(Self::Pbrt),
            "roa" => Ok(Self::RayOptics),
            "txt" if text.to_ascii_lowercase().contains("[lens data]") => Ok(Self::OpticalBench),
            "json" if text.contains("\"surface_group\"") => Ok(Self::Optiland),
            "json" if text.contains("\"optical_model\"") => Ok(Self::RayOptics),
            "json" => Ok(Self::Json),
            _ => {
                let message = format!("a file that ends in {ending:?} is none of a lens");
                Err(Invalid::new("", message).help(
                    "lenses are read from .toml and .json (photosite's own, Optiland's), .zmx, .seq, .txt (Optical Bench, \
                     with a section [lens data]), .dat (pbrt) and .roa",
                ))
            }
        }
    }
}

/// A lens that was read.
#[derive(Debug)]
pub struct Reading {
    /// The prescription, which a [`Lens`] can be made of.
    pub prescription: Prescription,
    /// The lens, in its first position.
    pub lens: Lens,
    /// What was read, assumed and ignored.
    pub report: Report,
}

/// Reads a lens file.
///
/// # Errors
///
/// What is wrong, with the line and the surface: a value that cannot be used, a glass or a kind of surface that is not
/// known, a lens that makes no picture.
pub fn read(bytes: &[u8], path: &Path) -> photosite_core::Result<Reading> {
    let text = text::decoded(bytes).map_err(|invalid| invalid.in_file(path))?;
    let format = Format::of(path, &text).map_err(|invalid| invalid.in_file(path))?;
    drafted(format, &text)
        .and_then(|draft| finish::finish(format, draft))
        .map_err(|fault| placed(fault, format, path, &text))
}

fn drafted(format: Format, text: &str) -> Read<Draft> {
    match format {
        Format::Toml => neutral::read_toml(text),
        Format::Json => neutral::read_json(text),
        Format::Zmx => zmx::read(text),
        Format::Seq => seq::read(text),
        Format::OpticalBench => optical_bench::read(text),
        Format::Pbrt => pbrt::read(text),
        Format::Optiland => json_value::parsed(text).and_then(|value| optiland::read(&value)),
        Format::RayOptics => json_value::parsed(text).and_then(|value| rayoptics::read(&value)),
    }
}

/// A fault with its file, and the line of its key.
fn placed(fault: Fault, format: Format, path: &Path, text: &str) -> Error {
    let Fault { line, invalid } = fault;
    match (line, format) {
        (Some(line), _) => invalid.at_line(path, line),
        (None, Format::Toml) => match neutral::toml_span(text, &invalid.key) {
            Some(span) => invalid.in_text(path, text, span),
            None => invalid.in_file(path),
        },
        (None, Format::Json | Format::Optiland | Format::RayOptics) => {
            json::located(invalid, path, json_value::with_words_quoted(text).as_bytes())
        }
        (None, Format::Zmx | Format::Seq | Format::OpticalBench | Format::Pbrt) => invalid.in_file(path),
    }
}

/// The fault of a row, in the way of its format.
fn of_row(row: &Row, field: &str, invalid: Invalid) -> Fault {
    let Invalid { message, help, .. } = invalid;
    let key = match (row.line, field) {
        (Some(_), _) => row.name.clone(),
        (None, "") => row.key.clone(),
        (None, field) => format!("{}.{field}", row.key),
    };
    Fault { line: row.line, invalid: Invalid { key, message, help } }
}

fn too_many(count: usize) -> String {
    format!("{count} surfaces, where lenses have at most {MOST_SURFACES}")
}

fn too_many_surfaces(line: usize) -> Fault {
    Fault::at(line, format!("more than {MOST_SURFACES} surfaces"))
}

/// mm of a unit of length.
fn mm_of(unit: &str) -> Option<f64> {
    match unit.to_ascii_lowercase().as_str() {
        "mm" => Some(1.0),
        "cm" => Some(10.0),
        "in" | "inch" | "inches" => Some(25.4),
        "m" | "meter" | "meters" => Some(1000.0),
        _ => None,
    }
}

/// The first word of a record as a number above 0.
fn positive<S: AsRef<str>>(words: &[S], key: &str, line: usize) -> Read<f64> {
    let word = words.first().map_or("", |word| word.as_ref());
    match text::number(word) {
        Some(number) if number > 0.0 => Ok(number),
        Some(_) | None => Err(Fault::at(line, format!("{key} {word}: no number above 0"))),
    }
}

/// The patent that a title names: `US 7,535,658`, `JP 2019-008031 example 1`.
fn patent_in(text: &str) -> Option<String> {
    let lower = text.to_ascii_lowercase();
    let words: Vec<&str> = text.split_whitespace().collect();
    let is_number = |word: &str| word.chars().filter(char::is_ascii_digit).count() >= 5;
    let offices = ["US", "JP", "EP", "WO", "DE", "GB", "FR", "CN", "KR"];
    for (i, word) in words.iter().enumerate() {
        let bare = word.trim_matches(|c: char| !c.is_ascii_alphanumeric());
        let office = offices.iter().find(|office| bare.starts_with(**office));
        if let Some(office) = office {
            let rest = &bare[office.len()..];
            if is_number(rest) {
                return Some(bare.to_owned());
            }
            if rest.is_empty()
                && let Some(next) = words.get(i + 1).filter(|next| is_number(next))
            {
                return Some(format!("{office} {}", next.trim_end_matches([',', ';', '.', ')'])));
            }
        }
    }
    // "Patent 583336".
    let at = lower.find("patent")?;
    let word = text.get(at + "patent".len()..)?.split_whitespace().find(|word| is_number(word))?;
    Some(word.trim_matches(|c: char| !c.is_ascii_alphanumeric()).to_owned())
}
