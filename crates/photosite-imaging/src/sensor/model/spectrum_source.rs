//! How a sensor file names a function of wavelength.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A function of wavelength: a number (the same at every wavelength), the name of a spectrum that ships with photosite,
/// or { file = "curve.csv" }.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "expected a number, the name of a spectrum, or { file = \"curve.csv\" }")]
pub enum SpectrumSource {
    /// The same value at every wavelength.
    Number(f64),
    /// A spectrum that ships with photosite.
    Name(String),
    /// A CSV file of wavelengths in nm and values.
    File(CurveFile),
}

/// A CSV file of wavelengths in nm and values.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveFile {
    /// Its path, relative to the file that names it.
    pub file: String,
}
