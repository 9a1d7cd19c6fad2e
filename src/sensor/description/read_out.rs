//! `[charge]` and `[adc]`: what a pixel holds, and how that becomes a number.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Charge storage.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChargeDescription {
    /// Most electrons that a pixel can hold.
    pub full_well_e: f64,
}

/// Analogue gain and analogue-to-digital converter.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdcDescription {
    /// Bits of the converter, 8–16.
    pub bits: u32,
    /// System gain K at 0 dB, DN per electron.
    pub conversion_gain_dn_per_e: f64,
    /// Digital number of no charge.
    pub black_level_dn: u32,
    /// Smallest and largest gain that an exposure may ask for, dB.
    pub gain_db_range: [f64; 2],
}
