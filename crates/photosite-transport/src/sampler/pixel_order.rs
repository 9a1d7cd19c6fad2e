//! Order in which the pixels share sequences of random numbers.

use super::SamplerKind;

/// Shares sequences out among the pixels of an image.
///
/// The pixels of a square share a sequence of Sobol points in Z order, so that all smaller squares of 2ⁿ × 2ⁿ pixels
/// have an interval of it: their samples are stratified together as those of one pixel are. The error of each pixel
/// stays what it was, that of the mean of neighbours shrinks; it is spread like blue noise (A. Ahmed, P. Wonka,
/// "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", SIGGRAPH Asia
/// 2020).
#[derive(Clone, Copy, Debug)]
pub struct PixelOrder {
    /// Squares in a row of the image.
    squares: u64,
    /// Binary logarithm of the number of pixels along a square.
    log2_side: u32,
    /// Binary logarithm of the number of samples that each pixel has room for.
    log2_samples: u32,
}

/// Binary logarithm of the number of pixels along the largest square.
const LARGEST: u32 = 6;

impl PixelOrder {
    /// Makes the order of an image `width` pixels wide, with at most `samples` samples a pixel in the whole render,
    /// each of which splits into `splitting` paths. The more paths there are, the smaller are the squares, since
    /// indices of samples have 32 bits.
    pub fn new(kind: SamplerKind, width: u32, samples: u32, splitting: u32) -> Self {
        let log2 = |n: u32| u32::BITS - n.saturating_sub(1).leading_zeros();
        let room = u32::BITS.saturating_sub(log2(samples) + log2(splitting));
        let log2_side = match kind {
            SamplerKind::Sobol => LARGEST.min(room / 2),
            SamplerKind::Independent => 0,
        };
        let squares = u64::from(width).div_ceil(1 << log2_side);
        Self { squares, log2_side, log2_samples: log2(samples) }
    }

    /// Plain data: squares in a row of the image, binary logarithms of the pixels along a square and of the samples of
    /// a pixel. `None` where an image of `rows` rows has more squares than numbers of 32 bits tell apart.
    pub(crate) fn numbers(&self, rows: u32) -> Option<[u32; 3]> {
        let squares = self.squares * u64::from(rows).div_ceil(1 << self.log2_side);
        (squares <= 1 << 32).then_some([self.squares as u32, self.log2_side, self.log2_samples])
    }

    /// The number of the sequence of a pixel in column x and row y, and the index of the pixel's first sample in it.
    #[inline]
    pub fn place(&self, [x, y]: [u32; 2]) -> (u64, u32) {
        let square = u64::from(y >> self.log2_side) * self.squares + u64::from(x >> self.log2_side);
        let within = (1 << self.log2_side) - 1;
        let in_square = spread(x & within) | spread(y & within) << 1;
        (square, in_square.checked_shl(self.log2_samples).unwrap_or(0))
    }
}

/// Bits below 2^[`LARGEST`] moved to every other place.
#[inline]
fn spread(mut bits: u32) -> u32 {
    bits = (bits | bits << 4) & 0x0f0f;
    bits = (bits | bits << 2) & 0x3333;
    (bits | bits << 1) & 0x5555
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::sampler::Sampler;

    #[test]
    fn no_two_paths_of_an_image_have_the_same_numbers() {
        for (samples, splitting) in [(1, 1), (3, 1), (8, 3), (5, 256)] {
            let order = PixelOrder::new(SamplerKind::Sobol, 130, samples, splitting);
            let mut seen = HashSet::new();
            for pixel in (0..70).flat_map(|y| (0..130).map(move |x| [x, y])) {
                let (sequence, first) = order.place(pixel);
                for path in 0..samples * splitting {
                    let index = (first + path / splitting) * splitting + path % splitting;
                    assert!(seen.insert((sequence, index)), "{pixel:?}, path {path}");
                }
            }
        }
    }

    #[test]
    fn pixels_stand_for_themselves_where_indices_have_no_room_and_where_numbers_are_independent() {
        for (kind, samples, splitting) in
            [(SamplerKind::Sobol, u32::MAX, 1), (SamplerKind::Sobol, 1 << 24, 256), (SamplerKind::Independent, 16, 1)]
        {
            let order = PixelOrder::new(kind, 100, samples, splitting);
            assert_eq!([[0, 0], [99, 0], [7, 3]].map(|pixel| order.place(pixel)), [(0, 0), (99, 0), (307, 0)]);
        }
    }

    #[test]
    fn samples_of_a_square_are_stratified_together() {
        let order = PixelOrder::new(SamplerKind::Sobol, 100, 4, 1);
        let mut sampler = Sampler::new(SamplerKind::Sobol, 3);
        for corner in [[8, 16], [64, 0], [0, 72]] {
            let mut strata = [[0; 256]; 3];
            for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
                let (sequence, first) = order.place([corner[0] + x, corner[1] + y]);
                for sample in 0..4 {
                    sampler.start(sequence, first + sample);
                    let [u, v] = sampler.next_2d();
                    for (strata, u) in strata.iter_mut().zip([u, v, sampler.next_1d()]) {
                        strata[(u * 256.0) as usize] += 1;
                    }
                }
            }
            assert_eq!(strata, [[1; 256]; 3], "{corner:?}");
        }
    }

    #[test]
    fn the_mean_of_neighbours_is_better_known_than_of_pixels_that_do_not_know_of_each_other() {
        // ∫ over the unit square of a smooth function, by 4 samples a pixel.
        let side = 64;
        let f = |u: f32, v: f32| f64::from((3.0 * u + v).sin() + u * v);
        let order = PixelOrder::new(SamplerKind::Sobol, side, 4, 1);
        let error = |[x, y]: [u32; 2]| {
            let (sequence, first) = order.place([x, y]);
            let mut sampler = Sampler::new(SamplerKind::Sobol, 3);
            let values = (first..first + 4).map(|index| {
                sampler.start(sequence, index);
                let [u, v] = sampler.next_2d();
                f(u, v)
            });
            // ∫₀¹∫₀¹ sin(3u + v) du dv = (sin 3 + sin 1 − sin 4)/3.
            let exact = (3f64.sin() + 1f64.sin() - 4f64.sin()) / 3.0 + 0.25;
            values.sum::<f64>() / 4.0 - exact
        };
        let mean_square = |block: u32| {
            let blocks = (0..side / block).flat_map(|y| (0..side / block).map(move |x| [x * block, y * block]));
            let means = blocks.map(|[x, y]| {
                let pixels = (0..block * block).map(|i| error([x + i % block, y + i / block]));
                pixels.sum::<f64>() / f64::from(block * block)
            });
            means.map(|mean| mean * mean).sum::<f64>() / f64::from((side / block).pow(2))
        };
        // Independent pixels: 1/16 of the variance.
        let (one, sixteen) = (mean_square(1), mean_square(4));
        assert!(sixteen < one / 16.0 / 4.0, "{one} and {sixteen}");
    }
}
