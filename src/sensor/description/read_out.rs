//! `[charge]` and `[adc]`: what a pixel holds, and how that becomes a number.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::DualGainDescription;

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
    /// Two converters at two gains, whose numbers are merged into one of the bits and the gain above.
    pub dual_gain: Option<DualGainDescription>,
}
