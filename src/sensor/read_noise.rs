//! Read noise: what the amplifiers between pixel and converter add, referred to the charge at their input.

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::units::Electrons;

use super::noise_key::{NoiseKey, NoiseStage, PixelStreams};

/// Adds normally distributed noise.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReadNoise {
    standard_deviation: f64,
    streams: PixelStreams,
}

impl ReadNoise {
    pub(super) fn new(standard_deviation: Electrons, key: NoiseKey) -> Self {
        Self { standard_deviation: standard_deviation.0, streams: key.temporal(NoiseStage::ReadNoise) }
    }

    /// The signal with noise, e⁻; below zero it stays.
    #[inline]
    pub(super) fn apply(&self, charge_e: f64, pixel: usize) -> f64 {
        let deviation: f64 = self.streams.pixel(pixel).sample(StandardNormal);
        charge_e + self.standard_deviation * deviation
    }
}
