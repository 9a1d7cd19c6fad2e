//! What a sensor file says, before it is checked: the keys of `assets/sensors/*.toml` and of a capture file's
//! `[sensor]` table, in the units that they name. Doc comments become the JSON Schema's descriptions.

mod noise;
mod read_out;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use noise::NoiseDescription;
pub use read_out::{AdcDescription, ChargeDescription};

/// An image sensor: pixels, colour filters, noise, charge capacity and converter.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensorDescription {
    /// What this sensor is, in a sentence.
    #[serde(default)]
    pub description: String,
    /// Where its numbers come from.
    #[serde(default)]
    pub source: String,
    /// Technology of the pixels.
    #[serde(default)]
    pub kind: SensorKind,
    /// Columns and rows of pixels.
    pub resolution_px: [u32; 2],
    /// Distance between pixel centres along x and y, µm.
    pub pixel_pitch_um: [f64; 2],
    /// Part of a pixel's area that is sensitive to light, above 0 up to 1. Leave it at 1 where the quantum efficiency was
    /// measured for whole pixels, as EMVA 1288 does.
    #[serde(default = "one")]
    pub fill_factor: f64,
    /// Colour filter array: "mono"; a tile, row by row from the top-left pixel ("RGGB", or "RGRG/GBGB" with its rows apart);
    /// "quad-bayer", "nona-bayer", "x-trans", "rgbw", "rgb-ir", "rccb", "rccc", "ryyb" or "cygm"; or "full:RGB" for all
    /// channels at every pixel.
    pub cfa: String,
    /// A filter in front of all pixels, such as one that blocks infrared.
    #[serde(default)]
    pub filter: FilterDescription,
    /// One table per channel: R, G and B, or Y for a monochrome sensor.
    pub channels: BTreeMap<String, ChannelDescription>,
    /// Noise sources.
    pub noise: NoiseDescription,
    /// Charge storage.
    pub charge: ChargeDescription,
    /// Analogue gain and analogue-to-digital converter.
    pub adc: AdcDescription,
}

fn one() -> f64 {
    1.0
}

/// Technology of the pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SensorKind {
    /// Charge becomes a voltage inside each pixel.
    #[default]
    Cmos,
}

/// A filter in front of all pixels.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FilterDescription {
    /// Transmittance, 0–1 at every wavelength; 1 where left out.
    pub transmittance: Option<SpectrumSource>,
}

/// One channel of the sensor.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChannelDescription {
    /// Photo-electrons per photon that reaches the pixel, colour filter included, 0–1 at every wavelength.
    pub quantum_efficiency: SpectrumSource,
}

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
