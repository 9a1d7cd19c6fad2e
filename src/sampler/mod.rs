//! Where the random numbers of light transport come from.
//!
//! A [`Sampler`] is a pure function of (seed, sequence, index, dimension), and [`PixelOrder`] gives each sample of a picture a
//! sequence and an index, so a picture can be computed in any order, in parts, and on any number of threads. In: those four.
//! Out: numbers in [0, 1).

mod pixel_order;
mod sobol;

pub use pixel_order::PixelOrder;

use crate::math::hash::{first_half, hash64, hash64_halves, second_half, unit_f32};

/// Random number sequences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplerKind {
    /// Owen-scrambled Sobol points, shared by neighbours in [`PixelOrder`].
    Sobol,
    /// Independent random numbers: more noise, but the reported variance is exact.
    Independent,
}

impl SamplerKind {
    /// The name that capture files use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sobol => "sobol",
            Self::Independent => "independent",
        }
    }
}

/// The numbers of one camera path, dimension by dimension.
#[derive(Clone, Debug)]
pub struct Sampler {
    kind: SamplerKind,
    /// [`first_half`] of the key of the sequence.
    key: u64,
    /// Index of the sample in the sequence.
    index: u32,
    /// Its bits in reverse.
    reversed_index: u32,
    dimension: u32,
}

impl Sampler {
    /// Sample `index` of a sequence of a render with `seed`.
    #[inline]
    pub fn new(kind: SamplerKind, seed: u64, sequence: u64, index: u32) -> Self {
        Self {
            kind,
            key: first_half(hash64(seed, sequence)),
            index,
            reversed_index: index.reverse_bits(),
            dimension: 0,
        }
    }

    /// The numbers from here on of one of `count` paths that go on together. Those of all samples of the sequence are
    /// stratified together too.
    #[inline]
    pub fn branch(&self, branch: u32, count: u32) -> Self {
        let index = self.index.wrapping_mul(count).wrapping_add(branch);
        Self { index, reversed_index: index.reverse_bits(), ..self.clone() }
    }

    /// The next number in [0, 1).
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        let key = self.next_key();
        match self.kind {
            SamplerKind::Sobol => unit_f32(sobol::scrambled_1d(self.reversed_index, key)),
            SamplerKind::Independent => unit_f32(hash64(key, u64::from(self.index)) as u32),
        }
    }

    /// Leaves out what [`Self::next_1d`] or [`Self::next_2d`] would give.
    #[inline]
    pub fn skip(&mut self) {
        self.dimension += 1;
    }

    /// The next two numbers in [0, 1), stratified together.
    #[inline]
    pub fn next_2d(&mut self) -> [f32; 2] {
        let key = self.next_key();
        match self.kind {
            SamplerKind::Sobol => sobol::scrambled_2d(self.reversed_index, key).map(unit_f32),
            SamplerKind::Independent => {
                let bits = hash64(key, u64::from(self.index));
                [unit_f32(bits as u32), unit_f32((bits >> 32) as u32)]
            }
        }
    }

    /// A key of its own for each request, the same for all samples of the sequence.
    #[inline]
    fn next_key(&mut self) -> u64 {
        self.dimension += 1;
        let dimension = DIMENSIONS.get(self.dimension as usize).copied();
        hash64_halves(self.key, dimension.unwrap_or_else(|| second_half(u64::from(self.dimension))))
    }
}

/// [`second_half`] of the dimensions that most paths come by.
static DIMENSIONS: [u64; 64] = {
    let mut halves = [0; 64];
    let mut dimension = 0;
    while dimension < 64 {
        halves[dimension] = second_half(dimension as u64);
        dimension += 1;
    }
    halves
};

#[cfg(test)]
mod tests {
    use super::*;

    /// Means over 64 pixels × 256 samples of the first two dimensions.
    fn means(kind: SamplerKind) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for pixel in 0..64 {
            for index in 0..256 {
                let [u, v] = Sampler::new(kind, 1, pixel, index).next_2d();
                sums[0] += f64::from(u);
                sums[1] += f64::from(v);
            }
        }
        sums.map(|s| s / (64.0 * 256.0))
    }

    #[test]
    fn both_kinds_are_uniform() {
        // Independent: σ = 1/√(12 · 16384) = 0.0023. Stratified: far less.
        for (kind, tolerance) in [(SamplerKind::Independent, 4.0 * 0.0023), (SamplerKind::Sobol, 4e-4)] {
            for mean in means(kind) {
                assert!((mean - 0.5).abs() < tolerance, "{kind:?}: {mean}");
            }
        }
    }

    #[test]
    fn branches_of_all_samples_are_stratified_together() {
        let mut strata = [0; 64];
        for index in 0..16 {
            let mut sampler = Sampler::new(SamplerKind::Sobol, 5, 9, index);
            sampler.next_2d();
            for branch in 0..4 {
                strata[(sampler.branch(branch, 4).next_1d() * 64.0) as usize] += 1;
            }
        }
        assert_eq!(strata, [1; 64]);
    }

    #[test]
    fn all_requests_of_a_sample_are_independent() {
        // Two of one number and one of two: their pairs fill an 8 × 8 grid evenly, in a pixel of many samples.
        let n = 1 << 14;
        let mut counts = [[0f64; 64]; 6];
        for index in 0..n {
            let mut sampler = Sampler::new(SamplerKind::Sobol, 5, 9, index);
            let (a, b, [c, d]) = (sampler.next_1d(), sampler.next_1d(), sampler.next_2d());
            let cell = |x: f32| (x * 8.0) as usize;
            for (counts, [x, y]) in counts.iter_mut().zip([[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]]) {
                counts[8 * cell(x) + cell(y)] += 1.0;
            }
        }
        let expected = f64::from(n) / 64.0;
        for (pair, counts) in counts.iter().enumerate() {
            // Independent numbers: χ² of 49 degrees of freedom with even margins, 49 ± 9.9.
            let chi_squared: f64 = counts.iter().map(|count| (count - expected).powi(2) / expected).sum();
            assert!(chi_squared < 49.0 + 4.5 * 9.9, "pair {pair}: {chi_squared}");
        }
    }

    #[test]
    fn dimensions_of_one_sample_are_not_correlated() {
        let mut products = 0.0;
        let n = 1 << 14;
        for index in 0..n {
            let mut sampler = Sampler::new(SamplerKind::Sobol, 5, 9, index);
            products += (f64::from(sampler.next_1d()) - 0.5) * (f64::from(sampler.next_2d()[0]) - 0.5);
        }
        // Independent numbers: σ of the mean product = 1/12/√n = 0.00065.
        assert!((products / f64::from(n)).abs() < 4.0 * 0.00065, "{products}");
    }
}
