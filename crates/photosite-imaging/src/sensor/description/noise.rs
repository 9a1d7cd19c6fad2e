//! `[noise]` and `[defects]`: what makes pixels differ, from each other and from one picture to the next.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Noise sources, all at a gain of 0 dB and referred to electrons. What is left out is not there.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseDescription {
    /// Temporal dark noise of the read-out, standard deviation in e⁻.
    pub read_noise_e: f64,
    /// Gives read noise the heavy tails of Student's t distribution with so many degrees of freedom, above 2 (few: heavy);
    /// its standard deviation stays. Left out: a normal distribution.
    pub read_noise_degrees_of_freedom: Option<f64>,
    /// Dark current at the reference temperature, mean of all pixels without the hot ones, e⁻/s per pixel.
    pub dark_current_e_per_s: f64,
    /// Temperature at which the dark current is as stated, that of hot pixels too, °C; needed where there is any.
    pub dark_current_reference_c: Option<f64>,
    /// How the dark current rises with temperature. Left out: "doubling".
    pub dark_current_law: DarkCurrentLawName,
    /// Rise of temperature that doubles the dark current, K; needed where that is the law and there is any.
    pub dark_current_doubling_k: Option<f64>,
    /// Band gap for the law "arrhenius", eV. Left out: that of silicon, which shrinks with temperature.
    pub dark_current_band_gap_ev: Option<f64>,
    /// Dark current non-uniformity: spatial standard deviation of the dark current in percent of its mean. Pixels follow a
    /// log-normal distribution.
    pub dark_current_nonuniformity_percent: f64,
    /// Photo response non-uniformity: spatial standard deviation of the response in percent of its mean.
    pub prnu_percent: f64,
    /// The part of it that the pixels of a row share, %; it comes on top.
    pub prnu_row_percent: f64,
    /// The part of it that the pixels of a column share, %; it comes on top.
    pub prnu_column_percent: f64,
    /// Dark signal non-uniformity: spatial standard deviation of the dark signal, e⁻.
    pub dsnu_e: f64,
    /// The part of it that the pixels of a row share, e⁻; it comes on top.
    pub dsnu_row_e: f64,
    /// The part of it that the pixels of a column share, e⁻; it comes on top.
    pub dsnu_column_e: f64,
    /// Temporal noise that the pixels of a row share, standard deviation in e⁻.
    pub row_noise_e: f64,
    /// Temporal noise that the pixels of a column share, standard deviation in e⁻.
    pub column_noise_e: f64,
    /// Noise of resetting the sense node (kTC).
    pub reset: ResetDescription,
    /// Noise whose power falls with frequency (1/f).
    pub flicker: FlickerDescription,
    /// Pixels that jump between two levels (random telegraph signal).
    pub telegraph: TelegraphDescription,
    /// Pixels of a million that arrive as 0 or the largest number, new ones in every picture (salt and pepper).
    pub transmission_errors_per_million: f64,
}

/// How the dark current rises with temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DarkCurrentLawName {
    /// It doubles every so many kelvin (dark_current_doubling_k).
    #[default]
    Doubling,
    /// As T^(3/2)·exp(−E_g/(2kT)), thermal generation across the band gap.
    Arrhenius,
}

/// Noise of resetting the sense node: √(kTC)/q electrons.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ResetDescription {
    /// Its standard deviation, e⁻.
    pub noise_e: Option<f64>,
    /// Capacitance of the sense node, fF, in place of noise_e: the noise follows the temperature.
    pub capacitance_ff: Option<f64>,
    /// Whether the level after the reset is subtracted, which takes all of this noise away. Left out: false.
    pub correlated_double_sampling: bool,
}

/// Noise whose power falls with frequency as 1/f^exponent.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FlickerDescription {
    /// Its standard deviation, e⁻: all frequencies together, from once a picture to every second sample;
    /// pictures of a series have none of it in common.
    pub noise_e: f64,
    /// Exponent of the frequency, above 0 up to 2. Left out: 1.
    pub exponent: f64,
    /// Which samples follow each other in one amplifier. Left out: "column-parallel".
    pub order: FlickerOrder,
}

impl Default for FlickerDescription {
    fn default() -> Self {
        Self { noise_e: 0.0, exponent: 1.0, order: FlickerOrder::ColumnParallel }
    }
}

/// Which samples follow each other in one amplifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FlickerOrder {
    /// Every column has an amplifier, which reads its pixels from top to bottom.
    ColumnParallel,
    /// One amplifier reads all pixels, row by row.
    Serial,
}

/// Pixels that jump between two levels as a trap in their amplifier fills and empties.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TelegraphDescription {
    /// Pixels of a million that do.
    pub pixels_per_million: f64,
    /// Mean distance of the two levels, e⁻; pixels follow an exponential distribution.
    pub amplitude_e: f64,
    /// Mean time on the high level, s.
    pub high_s: f64,
    /// Mean time on the low level, s.
    pub low_s: f64,
}

impl Default for TelegraphDescription {
    fn default() -> Self {
        Self { pixels_per_million: 0.0, amplitude_e: 0.0, high_s: 1.0, low_s: 1.0 }
    }
}

/// Pixels that do not work as the others, in places of their own on every sensor (its seed). What is left out is not
/// there.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DefectsDescription {
    /// Pixels of a million with more dark current than others.
    pub hot_per_million: f64,
    /// The mean of what hot pixels have more at the reference temperature, e⁻/s; they follow an exponential distribution.
    pub hot_dark_current_e_per_s: f64,
    /// Pixels of a million that do not see light.
    pub dead_per_million: f64,
    /// Pixels of a million that always read the same number, any number of the converter.
    pub stuck_per_million: f64,
}
