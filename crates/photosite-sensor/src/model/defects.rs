//! `[defects]`: pixels that do not work as the others.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

use super::checks::{in_a_million, not_negative};

/// Pixels that do not work as the others, in places of their own on every sensor (its seed). What is left out is not
/// there.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct DefectsDescription {
    /// Pixels of a million with more dark current than others.
    #[schemars(transform = within(0.0..=1e6))]
    pub hot_per_million: f64,
    /// The mean of what hot pixels have more at the reference temperature, e⁻/s; they follow an exponential
    /// distribution.
    #[schemars(transform = within(0.0..))]
    pub hot_dark_current_e_per_s: f64,
    /// Pixels of a million that do not see light.
    #[schemars(transform = within(0.0..=1e6))]
    pub dead_per_million: f64,
    /// Pixels of a million that always read the same number, any number of the converter.
    #[schemars(transform = within(0.0..=1e6))]
    pub stuck_per_million: f64,
    /// Defective pixels by their places, of one sensor, in place of the keys above: a CSV file of `column,row,kind,value`
    /// with the kinds hot (e⁻/s at the reference temperature), dead and stuck (DN).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixels: Option<DefectFile>,
}

/// A CSV file of defective pixels: a line `column,row,kind,value`, and one for each pixel. Kinds are `hot`, with what the
/// pixel has more of dark current at the reference temperature in e⁻/s; `dead`, without a value; and `stuck`, with the
/// number that it reads.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct DefectFile {
    /// Path of the file, relative to the file that names it.
    pub file: String,
}

/// Pixels that do not work as the others, as parts of all, 0–1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Defects {
    /// Hot pixels, with more dark current.
    pub hot: f64,
    /// Mean additional dark current of hot pixels at the reference temperature, e⁻/s, exponentially distributed.
    pub hot_dark_current_e_per_s: f64,
    /// Dead pixels, which do not see light.
    pub dead: f64,
    /// Stuck pixels, which always read the same number.
    pub stuck: f64,
}

impl Defects {
    pub(super) fn new(d: &DefectsDescription) -> Result<Self, Invalid> {
        Ok(Self {
            hot: in_a_million("hot_per_million", d.hot_per_million)?,
            hot_dark_current_e_per_s: not_negative("hot_dark_current_e_per_s", d.hot_dark_current_e_per_s)?,
            dead: in_a_million("dead_per_million", d.dead_per_million)?,
            stuck: in_a_million("stuck_per_million", d.stuck_per_million)?,
        })
    }
}
