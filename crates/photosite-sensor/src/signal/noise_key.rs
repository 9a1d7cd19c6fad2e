//! Sensor's random numbers: one stream for every (seed, frame, stage, pixel), and for fixed patterns one for every
//! (serial number, stage, pixel), so that the noise of a pixel does not depend on threads, on the order of pixels, on
//! the size of the image, or on whether other stages are switched on.

use rand::RngExt;
use rand_distr::StandardNormal;

use photosite_core::math::hash::hash64;
use photosite_core::math::philox::{PAIRS, PairBlocks, Philox};

use super::charge_plane::Row;
use super::effects::Stage;
use super::words::StreamWords;

/// Key of the temporal noise of one image. Fixed patterns belong to the sensor, by its [serial
/// number](crate::SensorModel::serial), and do not depend on this key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoiseKey {
    /// Another seed is another take.
    pub seed: u64,
    /// Number of the image in a series.
    pub frame: u64,
}

/// Distinguishes the sensor's keys from those that other parts of the program derive from the same seed.
const SENSOR: u64 = 0x7365_6e73_6f72;

impl NoiseKey {
    /// Streams of a stage whose noise differs from frame to frame.
    pub(crate) fn temporal(self, stage: Stage) -> Streams {
        Streams { key: hash64(of_stage(self.seed, stage), hash64(1, self.frame)), row_mask: usize::MAX }
    }

    /// Streams of a stage whose noise goes on in time from one frame of a series to the next.
    pub(crate) fn in_time(self, stage: Stage) -> Streams {
        Streams { key: of_stage(self.seed, stage), row_mask: usize::MAX }
    }
}

fn of_stage(number: u64, stage: Stage) -> u64 {
    hash64(hash64(SENSOR, number), stage as u64)
}

/// The random numbers of one stage, a stream for each pixel, row or column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Streams {
    key: u64,
    /// 0 where all rows of an image come from the same row of pixels, else all ones.
    row_mask: usize,
}

impl Streams {
    /// Streams of a stage that marks the sensor of this serial number: the same in every image that it takes.
    pub(crate) fn fixed(serial: u64, stage: Stage) -> Self {
        Self { key: of_stage(serial, stage), row_mask: usize::MAX }
    }

    /// Streams for another need of the same stage, such as the part of a pattern that a row shares.
    pub(crate) fn part(self, number: u64) -> Self {
        Self { key: hash64(self.key, hash64(2, number)), ..self }
    }

    /// Streams of one row of pixels that sees all rows of an image: each row has the same.
    pub(crate) fn of_one_row(self) -> Self {
        Self { row_mask: 0, ..self }
    }

    /// Key from which all streams are derived, for numbers that are better hashed than drawn.
    pub(crate) fn key(&self) -> u64 {
        self.key
    }

    /// Words of the streams; those of a stage that draws none are the default.
    pub(crate) fn words(&self) -> StreamWords {
        StreamWords {
            is_there: 1,
            key_low: self.key as u32,
            key_high: (self.key >> 32) as u32,
            row_mask: self.row_mask as u32,
        }
    }

    /// The stream with this number.
    #[inline]
    pub(crate) fn stream(&self, number: usize) -> Philox {
        Philox::new(self.key, number as u64)
    }

    /// The stream that the pixels of row y share.
    #[inline]
    pub(crate) fn row(&self, y: usize) -> Philox {
        self.stream(y & self.row_mask)
    }

    /// The stream of the pixel at column x, row y.
    #[inline]
    pub(crate) fn pixel(&self, x: usize, y: usize) -> Philox {
        let [even, odd] = Philox::pair(self.key, self.number(x / 2, y));
        if x.is_multiple_of(2) { even } else { odd }
    }

    /// Many streams of the pixel at column x, row y.
    pub(crate) fn part_of_pixel(self, x: usize, y: usize) -> Self {
        self.part(self.number(x, y))
    }

    #[inline]
    fn number(&self, x: usize, y: usize) -> u64 {
        ((y & self.row_mask) as u64) << 32 | x as u64
    }

    /// A standard normal number for each of the streams 0 … count − 1, times `scale`; none where that is 0.
    pub(crate) fn normals_of_columns(&self, scale: f64, count: usize) -> Vec<f32> {
        let normal = |x| (scale * self.stream(x).sample::<f64, _>(StandardNormal)) as f32;
        if scale > 0.0 { (0..count).map(normal).collect() } else { Vec::new() }
    }

    /// The columns of some pixels of a row, each of which is taken with the same probability, from left to right. Which
    /// they are does not depend on the width of the image.
    pub(crate) fn chosen(&self, probability: f64, y: usize, width: usize) -> impl Iterator<Item = usize> {
        let mut random = self.row(y);
        // Gaps between the chosen are geometrically distributed: P(gap ≥ n) = (1 − p)ⁿ.
        let per_pixel = (-probability).ln_1p();
        let mut next = 0usize;
        std::iter::from_fn(move || {
            if probability <= 0.0 {
                return None;
            }
            // In (0, 1], so that the logarithm is finite.
            let uniform = 1.0 - random.random::<f64>();
            let gap = uniform.ln() / per_pixel;
            let x = next.saturating_add(gap as usize);
            next = x.saturating_add(1);
            (x < width).then_some(x)
        })
    }

    /// A standard normal number of the pixel at column x, row y.
    #[inline]
    pub(crate) fn normal(&self, x: usize, y: usize) -> f32 {
        self.pixel(x, y).sample(StandardNormal)
    }

    /// Changes each value of a row: hands its column, the value and the stream of its pixel to `change`.
    #[inline]
    pub(crate) fn pixels(&self, row: &mut Row<'_>, change: impl Fn(usize, f32, &mut Philox) -> f32) {
        for (block, values) in row.values.chunks_mut(2 * PAIRS).enumerate() {
            let blocks = PairBlocks::new(self.key, self.number(block * PAIRS, row.y));
            let mut x = block * 2 * PAIRS;
            for (pair, streams) in values.chunks_mut(2).zip(Philox::pairs(&blocks)) {
                for (value, mut random) in pair.iter_mut().zip(streams) {
                    *value = change(x, *value, &mut random);
                    x += 1;
                }
            }
        }
    }

    /// Changes a row as [`Self::pixels`] does, with a standard normal number of each pixel in place of its stream.
    #[inline]
    pub(crate) fn normals(&self, row: &mut Row<'_>, change: impl Fn(usize, f32, f32) -> f32) {
        self.pixels(row, |x, value, random| change(x, value, random.sample(StandardNormal)));
    }
}

#[cfg(test)]
mod tests {
    use rand::Rng;

    use super::*;

    #[test]
    fn pixels_are_chosen_with_their_probability_and_independently_of_the_width() {
        let streams = Streams::fixed(3, Stage::DeadPixels);
        for probability in [0.0, 1e-3, 0.3, 1.0] {
            let (width, rows) = (1000, 500);
            let count: usize = (0..rows).map(|y| streams.chosen(probability, y, width).count()).sum();
            let n = (width * rows) as f64;
            // Binomial, 5 σ.
            let tolerance = 5.0 * (n * probability * (1.0 - probability)).sqrt();
            assert!((count as f64 - n * probability).abs() <= tolerance, "{count} for {probability}");
            let narrow: Vec<_> = streams.chosen(probability, 7, 600).collect();
            let wide: Vec<_> = streams.chosen(probability, 7, width).take_while(|&x| x < 600).collect();
            assert_eq!(narrow, wide);
        }
    }

    #[test]
    fn temporal_noise_differs_by_seed_and_frame_and_fixed_patterns_by_serial_number() {
        let first = |streams: Streams| streams.pixel(3, 5).next_u64();
        let stage = Stage::DarkOffset;
        let temporal = |seed, frame| first(NoiseKey { seed, frame }.temporal(stage));
        assert_ne!(temporal(7, 0), temporal(7, 1));
        assert_ne!(temporal(7, 0), temporal(8, 0));
        let fixed = Streams::fixed(7, stage);
        assert_ne!(temporal(7, 0), first(fixed), "the same number serves both and makes nothing alike");
        assert_ne!(first(fixed), first(Streams::fixed(8, stage)));
        assert_ne!(first(fixed), first(Streams::fixed(7, Stage::PhotoResponse)));
        assert_ne!(first(fixed), first(fixed.part(0)));
        assert_ne!(first(fixed.part(1)), first(fixed.part(0)));
        assert_ne!(first(fixed), fixed.pixel(5, 3).next_u64());
    }
}
