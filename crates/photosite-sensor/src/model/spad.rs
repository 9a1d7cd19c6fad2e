//! `[spad]`: how single photons are counted, as a sensor file states it, and checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;
use photosite_core::units::Seconds;

use super::checks::{fraction_below_one, not_negative};

/// Single-photon counting.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct SpadDescription {
    /// Counting mode during an exposure.
    pub counting: CountingMode,
    /// One-bit frames whose sum is one image; `counting = "one-bit"` needs it.
    #[schemars(transform = within(1.0..=65_535.0))]
    pub one_bit_frames: Option<u32>,
    /// Time after each count in which further photons are missed, ns; `counting = "free-running"` needs it.
    #[schemars(transform = within(0.0..))]
    pub dead_time_ns: Option<f64>,
    /// Counts that are followed by another one without light, %.
    #[serde(default)]
    #[schemars(transform = within(0.0..100.0))]
    pub afterpulsing_percent: f64,
}

/// Counting mode of a single-photon detector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum CountingMode {
    /// Every photon that does not fall into the dead time of the one before.
    FreeRunning,
    /// Frames in which there was at least one photon (quanta image sensor).
    OneBit,
}

/// A single-photon detector.
#[derive(Clone, Debug, PartialEq)]
pub struct Spad {
    /// Counting mode of the detector.
    pub counting: Counting,
    /// Probability that a count is followed by another one without light, 0 to below 1.
    pub afterpulsing: f64,
}

/// Counting mode of a single-photon detector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Counting {
    /// Every photon that does not fall into the dead time of the one before.
    FreeRunning {
        /// Time after each count in which further photons are missed.
        dead_time: Seconds,
    },
    /// Frames in which there was at least one photon.
    OneBit {
        /// Frames whose sum is one image, 1 and more.
        frames: u32,
    },
}

/// More one-bit frames than this do not fit into a raw file's numbers.
const MAX_FRAMES: u32 = 65_535;

impl Spad {
    /// Keys of errors are those of the table `[spad]`.
    pub(super) fn new(d: &SpadDescription) -> Result<Self, Invalid> {
        let missing =
            |key: &str, example: &str| Invalid::new(key, "missing").help(format!("for example {key} = {example}"));
        let unused = |key: &str, mode: &str| {
            Invalid::new(key, format!("does not apply with counting = {mode:?}")).help("leave it out")
        };
        let counting = match (d.counting, d.dead_time_ns, d.one_bit_frames) {
            (CountingMode::FreeRunning, Some(dead_time_ns), None) => {
                not_negative("dead_time_ns", dead_time_ns)?;
                Counting::FreeRunning { dead_time: Seconds(dead_time_ns * 1e-9) }
            }
            (CountingMode::OneBit, None, Some(frames)) => {
                if !(1..=MAX_FRAMES).contains(&frames) {
                    let message = format!("must lie between 1 and {MAX_FRAMES}, got {frames}");
                    return Err(Invalid::new("one_bit_frames", message).help("for example one_bit_frames = 255"));
                }
                Counting::OneBit { frames }
            }
            (CountingMode::FreeRunning, _, Some(_)) => return Err(unused("one_bit_frames", "free-running")),
            (CountingMode::OneBit, Some(_), _) => return Err(unused("dead_time_ns", "one-bit")),
            (CountingMode::FreeRunning, None, None) => return Err(missing("dead_time_ns", "50.0")),
            (CountingMode::OneBit, None, None) => return Err(missing("one_bit_frames", "255")),
        };
        let afterpulsing = fraction_below_one("afterpulsing_percent", d.afterpulsing_percent / 100.0)
            .map_err(|_| Invalid::new("afterpulsing_percent", "must be at least 0 and below 100"))?;
        Ok(Self { counting, afterpulsing })
    }
}
