//! Photo response non-uniformity (PRNU): pixels differ in size, thickness and filter, so each turns a little more or
//! less of the light into charge. A fixed pattern, the same in every frame.

use rand::RngExt;
use rand_distr::StandardNormal;

use super::noise_key::{NoiseKey, NoiseStage, PixelStreams};

/// The response pattern of a sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct PhotoResponse {
    standard_deviation: f64,
    streams: PixelStreams,
}

impl PhotoResponse {
    /// `prnu`: spatial standard deviation over mean (PRNU₁₂₈₈, [Emva1288](crate::references#emva1288)).
    pub(super) fn new(prnu: f64, key: NoiseKey) -> Self {
        Self { standard_deviation: prnu, streams: key.fixed(NoiseStage::PhotoResponse) }
    }

    /// Mean electrons of this very pixel: μ·(1 + PRNU·n) with n standard normal. No pixel responds negatively.
    #[inline]
    pub(super) fn apply(&self, mean_e: f64, pixel: usize) -> f64 {
        let deviation: f64 = self.streams.pixel(pixel).sample(StandardNormal);
        mean_e * (1.0 + self.standard_deviation * deviation).max(0.0)
    }
}
