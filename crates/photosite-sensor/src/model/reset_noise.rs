//! `[noise.reset]`: reset noise of the sense node.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;
use photosite_core::units::Electrons;

use super::checks::{electrons, not_negative};

/// Noise of resetting the sense node: √(kTC)/q electrons.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct ResetDescription {
    /// Standard deviation of reset noise, e⁻.
    #[schemars(transform = within(0.0..))]
    pub noise_e: Option<f64>,
    /// Capacitance of the sense node, fF, in place of noise_e: the noise follows the temperature.
    #[schemars(transform = within(0.0..))]
    pub capacitance_ff: Option<f64>,
    /// Whether the level after the reset is subtracted, which takes all of this noise away. Left out: false.
    pub correlated_double_sampling: bool,
}

/// Reset of the sense node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reset {
    /// Subtracted by correlated double sampling, or too small to matter.
    Cancelled,
    /// A standard deviation.
    Fixed(Electrons),
    /// Noise of a capacitance, F, at the sensor's temperature.
    Capacitance(f64),
}

impl Reset {
    pub(super) fn new(d: &ResetDescription) -> Result<Self, Invalid> {
        let noise = match (d.noise_e, d.capacitance_ff) {
            (Some(_), Some(_)) => {
                return Err(Invalid::new("capacitance_ff", "cannot be combined with noise_e").help("keep one of them"));
            }
            (Some(noise), None) => Self::Fixed(electrons("noise_e", noise)?),
            (None, Some(capacitance)) => Self::Capacitance(not_negative("capacitance_ff", capacitance)? * 1e-15),
            (None, None) => Self::Cancelled,
        };
        Ok(if d.correlated_double_sampling { Self::Cancelled } else { noise })
    }
}
