//! Functions of wavelength, as a sensor file names them.

use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A function of wavelength: a number (the same at every wavelength), the name of a spectrum that ships with photosite,
/// or { file = "curve.csv" }.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected a number, the name of a spectrum, or { file = \"curve.csv\" }")]
pub enum SpectrumSource {
    /// One value for every wavelength.
    Number(f64),
    /// A spectrum that ships with photosite.
    Name(String),
    /// A CSV file of wavelengths in nm and values.
    File(CurveFile),
}

/// A CSV file of wavelengths in nm and one column of values, or several with names.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct CurveFile {
    /// Path of the file, relative to the file that names it.
    pub file: String,
    /// Name of the column of values in the file's first line. Left out: the only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
}
