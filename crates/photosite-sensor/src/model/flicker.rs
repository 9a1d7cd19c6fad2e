//! `[noise.flicker]`: noise whose power falls with frequency.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_core::units::Electrons;

use super::checks::electrons;

/// Noise whose power falls with frequency as 1/f^exponent.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct FlickerDescription {
    /// Standard deviation of flicker noise, e⁻: all frequencies together, from once an image to every second sample;
    /// images of a series have none of it in common.
    #[schemars(transform = within(0.0..))]
    pub noise_e: f64,
    /// Exponent of the frequency, above 0 up to 2. Left out: 1.
    #[schemars(transform = above(0.0..=2.0))]
    pub exponent: f64,
    /// Order of samples in one amplifier. Left out: "column-parallel".
    pub order: FlickerOrder,
}

impl Default for FlickerDescription {
    fn default() -> Self {
        Self { noise_e: 0.0, exponent: 1.0, order: FlickerOrder::ColumnParallel }
    }
}

/// Order of samples in one amplifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum FlickerOrder {
    /// Every column has an amplifier, which reads its pixels from top to bottom.
    ColumnParallel,
    /// One amplifier reads all pixels, row by row.
    Serial,
}

/// 1/f noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flicker {
    /// Standard deviation of all frequencies together.
    pub noise: Electrons,
    /// The power falls as 1/f^exponent; above 0 up to 2.
    pub exponent: f64,
    /// Order in which samples follow each other at the amplifier.
    pub order: FlickerOrder,
}

impl Flicker {
    pub(super) fn new(d: &FlickerDescription) -> Result<Self, Invalid> {
        if !(d.exponent > 0.0 && d.exponent <= 2.0) {
            return Err(Invalid::new("exponent", format!("must lie above 0 and up to 2, got {}", d.exponent))
                .help("for example exponent = 1.0"));
        }
        Ok(Self { noise: electrons("noise_e", d.noise_e)?, exponent: d.exponent, order: d.order })
    }
}
