//! `[noise]`: what makes pixels differ, from each other and from one picture to the next.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Noise sources, all at a gain of 0 dB and referred to electrons.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NoiseDescription {
    /// Temporal dark noise of the read-out, standard deviation in e⁻.
    pub read_noise_e: f64,
    /// Dark current at the reference temperature, e⁻/s per pixel.
    pub dark_current_e_per_s: f64,
    /// Temperature at which the dark current is as stated, °C.
    pub dark_current_reference_c: f64,
    /// Rise of temperature that doubles the dark current, K.
    pub dark_current_doubling_k: f64,
    /// Photo response non-uniformity: spatial standard deviation of the response in percent of its mean.
    pub prnu_percent: f64,
    /// The part of it that the pixels of a row share, %; it comes on top.
    #[serde(default)]
    pub prnu_row_percent: f64,
    /// The part of it that the pixels of a column share, %; it comes on top.
    #[serde(default)]
    pub prnu_column_percent: f64,
    /// Dark signal non-uniformity: spatial standard deviation of the dark signal, e⁻.
    pub dsnu_e: f64,
    /// The part of it that the pixels of a row share, e⁻; it comes on top.
    #[serde(default)]
    pub dsnu_row_e: f64,
    /// The part of it that the pixels of a column share, e⁻; it comes on top.
    #[serde(default)]
    pub dsnu_column_e: f64,
}
