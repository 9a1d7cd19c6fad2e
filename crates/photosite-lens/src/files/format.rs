//! The formats, and which one a file has.

use std::path::Path;

use photosite_core::Invalid;

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
    /// DeepLens' JSON.
    DeepLens,
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
            Self::DeepLens => "DeepLens JSON",
        }
    }

    /// The format of a file, by the ending of its name, and for JSON and texts by what is in it.
    pub(super) fn of(path: &Path, text: &str) -> Result<Self, Invalid> {
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
            "json" if text.contains("\"d_next\"") => Ok(Self::DeepLens),
            "json" => Ok(Self::Json),
            _ => {
                let message = format!("a file that ends in {ending:?} is not a lens file");
                Err(Invalid::new("", message).help(
                    "lenses are read from .toml and .json (photosite's own, Optiland's, ray-optics', DeepLens'), .zmx, .seq, .txt (Optical Bench, \
                     with a section [lens data]), .dat (pbrt) and .roa",
                ))
            }
        }
    }
}
