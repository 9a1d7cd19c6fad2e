//! `[charge]` and `[adc]`: what a pixel holds, and how that becomes a number.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::DualGainDescription;
use crate::sensor::image_lag::ImageLagDescription;

/// Charge storage.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChargeDescription {
    /// Most electrons that a pixel can hold, or most photons that it can count.
    pub full_well_e: f64,
    /// Brighter-fatter effect: correlation of neighbours along x and along y on a flat field, for each electron of its
    /// signal, 1/e⁻. Left out: none.
    #[serde(default)]
    pub brighter_fatter_per_e: [f64; 2],
    /// Image lag. Left out: none.
    pub image_lag: Option<ImageLagDescription>,
    /// Makes the pixels logarithmic: their voltage follows log(1 + i/i₀), with this photocurrent i₀, e⁻/s. Left out: they are
    /// linear.
    pub logarithmic_reference_e_per_s: Option<f64>,
}

/// Analogue gain and analogue-to-digital converter.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdcDescription {
    /// Bits of the converter, 8–16. Where a capture gives a preset other bits, what the preset states in digital numbers of this
    /// converter follows by the factor 2^(new − old), so that it takes the same charge, unless the capture states it too:
    /// conversion gain, black level, offsets of columns, inl_dn and knee points (but not dnl_dn, which is of a single
    /// step, nor the numbers of single-photon detectors, which are counts).
    pub bits: u32,
    /// System gain K at 0 dB, DN per electron.
    pub conversion_gain_dn_per_e: f64,
    /// Digital number of no charge.
    pub black_level_dn: u32,
    /// Smallest and largest gain that an exposure may ask for, dB. Left out: 0 dB alone.
    #[serde(default)]
    pub gain_db_range: [f64; 2],
    /// Nonlinearity of the amplifiers: a charge q passes as q·(1 + c₁·q/F + c₂·(q/F)² + …), with the full well F and these
    /// c₁, c₂ … in percent. Left out: linear.
    #[serde(default)]
    pub amplifier_nonlinearity_percent: Vec<f64>,
    /// Integral nonlinearity of the converter: it bends by so many DN in the middle of its range, upwards or downwards. With
    /// dual_gain, it is that of either converter in its own DN; so is dnl_dn.
    #[serde(default)]
    pub inl_dn: f64,
    /// Differential nonlinearity of the converter: standard deviation of the width of its steps, DN, up to 0.4. Steps
    /// stay as they are from picture to picture.
    #[serde(default)]
    pub dnl_dn: f64,
    /// Whether one converter serves all pixels or every column has its own. Left out: "per-column".
    #[serde(default)]
    pub converters: Converters,
    /// Spatial standard deviation of the gains of the columns' amplifiers, percent of their mean.
    #[serde(default)]
    pub column_gain_percent: f64,
    /// Spatial standard deviation of the offsets of the columns' converters, DN.
    #[serde(default)]
    pub column_offset_dn: f64,
    /// Numbers of fewer bits leave the sensor, along a curve. Left out: those of the converter.
    pub companding: Option<CompandingDescription>,
    /// Two converters at two gains, whose numbers are merged into one of the bits and the gain above.
    pub dual_gain: Option<DualGainDescription>,
}

/// How many converters there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Converters {
    /// Every column has its own.
    #[default]
    PerColumn,
    /// One for all pixels.
    One,
}

/// How numbers of the converter become those of fewer bits that leave the sensor. Raw files in the DNG format tell how to
/// make them linear again.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompandingDescription {
    /// Bits of the numbers that leave the sensor, 8 to those of the converter.
    pub bits: u32,
    /// Straight lines: both ends and the knees in between, each as [number of the converter, number that leaves the sensor],
    /// such as [[0, 0], [1024, 1024], [65535, 4095]].
    pub knee_points_dn: Option<Vec<[u32; 2]>>,
    /// In their place: numbers are x^(1/gamma), 1 to 5.
    pub gamma: Option<f64>,
}
