//! Dark signal non-uniformity (DSNU): every pixel's read-out starts from an offset of its own. A fixed pattern, the same
//! in every frame.

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::units::Electrons;

use super::noise_key::{NoiseKey, NoiseStage, PixelStreams};

/// The offset pattern of a sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct DarkOffset {
    standard_deviation: f64,
    streams: PixelStreams,
}

impl DarkOffset {
    /// `dsnu`: spatial standard deviation (DSNU₁₂₈₈, [Emva1288](crate::references#emva1288)).
    pub(super) fn new(dsnu: Electrons, key: NoiseKey) -> Self {
        Self { standard_deviation: dsnu.0, streams: key.fixed(NoiseStage::DarkOffset) }
    }

    /// The pixel's charge with its offset, which may be negative.
    #[inline]
    pub(super) fn apply(&self, charge_e: f64, pixel: usize) -> f64 {
        let deviation: f64 = self.streams.pixel(pixel).sample(StandardNormal);
        charge_e + self.standard_deviation * deviation
    }
}
