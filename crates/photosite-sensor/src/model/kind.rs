//! Technologies of pixels by name.

use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Technology of the pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum SensorKind {
    /// Charge becomes a voltage inside each pixel.
    #[default]
    Cmos,
    /// Charge is moved out of all pixels to one amplifier; the table `[ccd]` says how.
    Ccd,
    /// Single photons are counted in each pixel; the table `[spad]` says how.
    Spad,
}

impl SensorKind {
    /// Name of the kind of sensor in sensor files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cmos => "cmos",
            Self::Ccd => "ccd",
            Self::Spad => "spad",
        }
    }
}
