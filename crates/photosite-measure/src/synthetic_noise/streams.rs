//! Streams of random numbers: one for every (seed, kind of noise, channel, pixel).

use photosite_core::math::hash::hash64;
use photosite_core::math::philox::Philox;

/// Kinds of noise. Their numbers key the random numbers and are part of what a seed means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Speckle = 1,
    FilmGrain = 2,
    Gaussian = 3,
    Laplacian = 4,
    Uniform = 5,
    SigmaMap = 6,
    SaltAndPepper = 7,
}

/// Distinguishes these keys from those that other parts of the program derive from the same seed.
const SYNTHETIC: u64 = 0x7379_6e74_6865_7469;

/// The streams of one kind in one channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Streams {
    key: u64,
}

impl Streams {
    pub(super) fn new(seed: u64, kind: Kind, channel: usize) -> Self {
        Self { key: hash64(hash64(hash64(SYNTHETIC, seed), kind as u64), channel as u64) }
    }

    /// Stream of a pixel, which may lie beyond the edges of the image.
    pub(super) fn pixel(self, x: i32, y: i32) -> Philox {
        Philox::new(self.key, u64::from(y as u32) << 32 | u64::from(x as u32))
    }
}
