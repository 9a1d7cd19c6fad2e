//! Formats of lens files, and their detection.

use std::path::Path;

use photosite_core::Invalid;

/// Format of a lens file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// photosite's own form as TOML.
    Toml,
    /// photosite's own form as JSON.
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
    /// DeepLens' JSON.
    DeepLens,
}

/// Row of the table of formats: how a file of one is known.
struct Known {
    format: Format,
    /// Name for messages, which has the ending.
    name: &'static str,
    /// Ending of file names, in lower case.
    ending: &'static str,
    /// Word of the text, in lower case, where formats share an ending; empty for any text.
    word: &'static str,
}

const fn known(format: Format, name: &'static str, ending: &'static str, word: &'static str) -> Known {
    Known { format, name, ending, word }
}

/// All formats, in the order in which messages list them; of those that share an ending, any text comes last.
const FORMATS: [Known; 10] = [
    known(Format::Zmx, "OpticStudio (.zmx)", "zmx", ""),
    known(Format::Seq, "CODE V (.seq)", "seq", ""),
    known(Format::OpticalBench, "Optical Bench (.txt)", "txt", "[lens data]"),
    known(Format::Pbrt, "pbrt (.dat)", "dat", ""),
    known(Format::RayOptics, "ray-optics (.roa)", "roa", ""),
    known(Format::Optiland, "Optiland JSON", "json", "\"surface_group\""),
    known(Format::RayOptics, "ray-optics JSON", "json", "\"optical_model\""),
    known(Format::DeepLens, "DeepLens JSON", "json", "\"d_next\""),
    known(Format::Json, "photosite JSON", "json", ""),
    known(Format::Toml, "photosite TOML", "toml", ""),
];

/// Names of all formats, as a sentence lists them: "OpticStudio (.zmx), CODE V (.seq) or photosite TOML".
pub fn formats() -> String {
    let names = FORMATS.map(|known| known.name);
    format!("{} or {}", names[..names.len() - 1].join(", "), names[names.len() - 1])
}

/// Endings of lens files, in lower case, each once.
pub fn endings() -> Vec<&'static str> {
    let mut endings = FORMATS.map(|known| known.ending).to_vec();
    endings.dedup();
    endings
}

/// Names of the JSON formats of other programs, each with the key by which it is known.
pub(super) fn json_formats() -> impl Iterator<Item = (&'static str, &'static str)> {
    let of_others = |known: &Known| known.ending == "json" && !known.word.is_empty();
    FORMATS.into_iter().filter(of_others).map(|known| (known.name, known.word.trim_matches('"')))
}

impl Format {
    /// Name for messages.
    pub fn name(self) -> &'static str {
        FORMATS.into_iter().find(|known| known.format == self).map_or("", |known| known.name)
    }

    /// Format of a file, by the ending of its name, and for JSON and texts by the content.
    pub(super) fn of(path: &Path, text: &str) -> Result<Self, Invalid> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let text = text.to_ascii_lowercase();
        let found = FORMATS.into_iter().find(|known| known.ending == ending && text.contains(known.word));
        found.map(|known| known.format).ok_or_else(|| match FORMATS.iter().find(|known| known.ending == ending) {
            Some(Known { name, word, .. }) => {
                Invalid::new("", format!("holds no {word}, which {name} files have")).help("give the whole file")
            }
            None => Invalid::new("", format!("a file that ends in {ending:?} is not a lens file"))
                .help(format!("lenses are read from files of {}", formats())),
        })
    }
}
