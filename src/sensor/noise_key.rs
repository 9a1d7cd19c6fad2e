//! Where the sensor's random numbers come from: one stream for every (seed, frame, stage, pixel), so that the noise of a
//! pixel does not depend on threads, on the order of pixels, or on whether other stages are switched on.

use crate::math::hash::hash64;
use crate::math::philox::Philox;

/// What the noise of one picture is keyed by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoiseKey {
    /// Stands for the individual camera: fixed patterns depend on it alone.
    pub seed: u64,
    /// Number of the picture in a series: temporal noise differs from frame to frame.
    pub frame: u64,
}

/// The stages that draw random numbers. Their numbers are part of what a seed means: append, never reorder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum NoiseStage {
    /// Fixed pattern of the response (PRNU).
    PhotoResponse = 1,
    /// Number of photo-electrons.
    ShotNoise = 2,
    /// Number of thermal electrons.
    DarkCurrent = 3,
    /// Fixed pattern of the dark signal (DSNU).
    DarkOffset = 4,
    /// Noise of the read-out.
    ReadNoise = 5,
}

/// Distinguishes the sensor's keys from those that other parts of the program derive from the same seed.
const SENSOR: u64 = 0x7365_6e73_6f72;

impl NoiseKey {
    /// Streams of a stage whose noise differs from frame to frame.
    pub(super) fn temporal(self, stage: NoiseStage) -> PixelStreams {
        PixelStreams { key: hash64(self.fixed(stage).key, hash64(1, self.frame)) }
    }

    /// Streams of a stage that marks the sensor: the same in every frame.
    pub(super) fn fixed(self, stage: NoiseStage) -> PixelStreams {
        PixelStreams { key: hash64(hash64(SENSOR, self.seed), stage as u64) }
    }
}

/// The random numbers of one stage, a stream for each pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelStreams {
    key: u64,
}

impl PixelStreams {
    /// The stream of the pixel with this index, counted row by row.
    #[inline]
    pub(super) fn pixel(self, index: usize) -> Philox {
        Philox::new(self.key, index as u64)
    }
}

#[cfg(test)]
mod tests {
    use rand::Rng;

    use super::*;

    #[test]
    fn fixed_patterns_ignore_the_frame_and_temporal_noise_does_not() {
        let first = |streams: PixelStreams| streams.pixel(3).next_u64();
        let (a, b) = (NoiseKey { seed: 7, frame: 0 }, NoiseKey { seed: 7, frame: 1 });
        let stage = NoiseStage::DarkOffset;
        assert_eq!(first(a.fixed(stage)), first(b.fixed(stage)));
        assert_ne!(first(a.temporal(stage)), first(b.temporal(stage)));
        assert_ne!(first(a.temporal(stage)), first(a.fixed(stage)));
        assert_ne!(first(a.fixed(stage)), first(NoiseKey { seed: 8, frame: 0 }.fixed(stage)));
        assert_ne!(first(a.fixed(stage)), first(a.fixed(NoiseStage::PhotoResponse)));
    }
}
