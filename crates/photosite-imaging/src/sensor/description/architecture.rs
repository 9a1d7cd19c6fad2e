//! `[ccd]`, `[spad]` and `[adc.dual_gain]`: how charge is collected, moved and counted where that differs from one
//! amplifier in each pixel and one converter range.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a CCD moves its charge.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CcdDescription {
    /// Where charge goes when the exposure ends.
    pub architecture: CcdArchitecture,
    /// Charge-transfer inefficiency along a column: the part of a packet that stays behind at each shift.
    pub vertical_cti: f64,
    /// Charge-transfer inefficiency along the read-out register.
    pub horizontal_cti: f64,
    /// Interline: light that leaks into the vertical registers, dB, as data sheets state it (a tenth of the rows lit, read
    /// in the time of the exposure). No smear where left out.
    pub smear_db: Option<f64>,
    /// Interline: time to read one line, µs; smear grows with it.
    pub line_time_us: Option<f64>,
    /// Frame transfer: time to shift the picture by one row towards its storage, µs; smear grows with it.
    pub row_shift_time_us: Option<f64>,
    /// Multiple of the saturating light up to which a drain keeps a pixel from blooming. Left out: 1, no drain.
    pub anti_blooming_factor: Option<f64>,
    /// Wells of the read-out register before the first column; they come first in every row.
    pub prescan_columns: u32,
    /// Shifts beyond the last column.
    pub overscan_columns: u32,
    /// Shifts beyond the last row.
    pub overscan_rows: u32,
}

/// Where a CCD's charge goes when the exposure ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CcdArchitecture {
    /// Into a shielded register beside each column of pixels.
    #[default]
    Interline,
    /// Quickly, through the pixels, into a shielded storage area as large as the picture.
    FrameTransfer,
    /// Row by row, through the pixels, to the output, behind a shutter.
    FullFrame,
}

/// How single photons are counted.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpadDescription {
    /// What is counted during an exposure.
    pub counting: CountingMode,
    /// One-bit frames whose sum is one picture; `counting = "one-bit"` needs it.
    pub one_bit_frames: Option<u32>,
    /// Time after each count in which further photons are missed, ns; `counting = "free-running"` needs it.
    pub dead_time_ns: Option<f64>,
    /// Counts that are followed by another one without light, %.
    #[serde(default)]
    pub afterpulsing_percent: f64,
}

/// What a single-photon detector counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CountingMode {
    /// Every photon that does not fall into the dead time of the one before.
    FreeRunning,
    /// Frames in which there was at least one photon (quanta image sensor).
    OneBit,
}

/// Two converters at two gains that look at the same charge, and whose numbers are merged into one.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DualGainDescription {
    /// Bits of each of the two converters, 8–16. What a preset states in their numbers follows as with adc.bits.
    pub bits: u32,
    /// Number of no charge at each of the two.
    pub black_level_dn: u32,
    /// System gain of the one that takes small signals, DN per electron. Its noise is `noise.read_noise_e`.
    pub high_gain_dn_per_e: f64,
    /// System gain of the one that takes large signals, DN per electron.
    pub low_gain_dn_per_e: f64,
    /// Temporal dark noise of the latter, standard deviation in e⁻. Left out: none.
    #[serde(default)]
    pub low_gain_read_noise_e: f64,
}
