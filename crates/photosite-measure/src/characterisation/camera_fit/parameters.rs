//! Parameters of a fitted sensor, and what stands beside them.

use photosite_core::units::Celsius;
use serde::Serialize;

use super::measured::Measured;

/// Parameter of a sensor, found in images.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Key of the sensor file.
    pub key: &'static str,
    /// Unit of the value.
    pub unit: &'static str,
    /// Value with its standard error.
    #[serde(flatten)]
    pub measured: Measured,
}

/// Noise of the read-out at a gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedGainStep {
    /// Gain over that of the first step, dB.
    pub gain_db: f64,
    /// Gain as the images state it.
    pub name: String,
    /// Figures at that gain, under the keys of `[noise]`.
    pub parameters: Vec<Parameter>,
}

/// Key that a sensor file needs and that the images do not tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assumption {
    /// Key of the sensor file.
    pub key: &'static str,
    /// Value in TOML.
    pub value: String,
    /// Whether the value was stated beside the images.
    pub is_stated: bool,
    /// Reason, and what to do about it.
    pub reason: String,
}

/// Facts about a camera that images do not hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KnownFacts {
    /// System gain K, DN/e⁻, for images that do not tell it.
    pub system_gain: Option<f64>,
    /// Temperature of the sensor in images that do not state it.
    pub temperature: Option<Celsius>,
    /// Distance of the pixels, µm.
    pub pixel_pitch_um: Option<[f64; 2]>,
    /// Wavelength of the light, nm.
    pub wavelength_nm: Option<f64>,
}
