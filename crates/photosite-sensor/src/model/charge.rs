//! `[charge]`: what a pixel holds.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::image_lag::ImageLagDescription;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};

/// Charge storage.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct ChargeDescription {
    /// Most electrons that a pixel can hold, or most photons that it can count.
    #[schemars(transform = above(0.0..))]
    pub full_well_e: f64,
    /// Brighter-fatter effect: correlation of neighbours along x and along y on a flat field, for each electron of its
    /// signal, 1/e⁻. Left out: none.
    #[serde(default)]
    #[schemars(transform = within(0.0..))]
    pub brighter_fatter_per_e: [f64; 2],
    /// Image lag. Left out: none.
    pub image_lag: Option<ImageLagDescription>,
    /// Makes the pixels logarithmic: their voltage follows log(1 + i/i₀), with this photocurrent i₀, e⁻/s. Left out:
    /// they are linear.
    #[schemars(transform = above(0.0..))]
    pub logarithmic_reference_e_per_s: Option<f64>,
}
