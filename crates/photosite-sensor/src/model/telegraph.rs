//! `[noise.telegraph]`: random telegraph signals.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_core::units::{Electrons, Seconds};

use super::checks::{electrons, in_a_million, positive};

/// Pixels that jump between two levels as a trap in their amplifier fills and empties.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct TelegraphDescription {
    /// Pixels of a million that do.
    #[schemars(transform = within(0.0..=1e6))]
    pub pixels_per_million: f64,
    /// Mean distance of the two levels, e⁻; pixels follow an exponential distribution.
    #[schemars(transform = within(0.0..))]
    pub amplitude_e: f64,
    /// Mean time on the high level, s.
    #[schemars(transform = above(0.0..))]
    pub high_s: f64,
    /// Mean time on the low level, s.
    #[schemars(transform = above(0.0..))]
    pub low_s: f64,
}

impl Default for TelegraphDescription {
    fn default() -> Self {
        Self { pixels_per_million: 0.0, amplitude_e: 0.0, high_s: 1.0, low_s: 1.0 }
    }
}

/// Random telegraph signals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TelegraphSignal {
    /// Part of the pixels that have one, 0–1.
    pub pixels: f64,
    /// Mean distance of the two levels; pixels follow an exponential distribution.
    pub amplitude: Electrons,
    /// Mean time on the high level.
    pub high: Seconds,
    /// Mean time on the low level.
    pub low: Seconds,
}

impl TelegraphSignal {
    /// Part of the time on the high level.
    pub fn duty(&self) -> f64 {
        self.high.0 / (self.high.0 + self.low.0)
    }

    /// Variance of all pixels, (e⁻)²: a part of them has A²·d·(1 − d) with the duty d, and the mean square of an
    /// exponential distribution is twice the square of its mean.
    pub fn variance(&self) -> f64 {
        self.pixels * 2.0 * self.amplitude.0.powi(2) * self.duty() * (1.0 - self.duty())
    }
}

impl TelegraphSignal {
    pub(super) fn new(d: &TelegraphDescription) -> Result<Self, Invalid> {
        Ok(Self {
            pixels: in_a_million("pixels_per_million", d.pixels_per_million)?,
            amplitude: electrons("amplitude_e", d.amplitude_e)?,
            high: Seconds(positive("high_s", d.high_s, "0.5")?),
            low: Seconds(positive("low_s", d.low_s, "0.5")?),
        })
    }
}
