//! Random numbers of light transport.
//!
//! The numbers of a [`Sampler`] are a pure function of (seed, sequence, index, dimension), and [`PixelOrder`] gives
//! each sample of an image a sequence and an index, so an image can be computed in any order, in parts, and on any
//! number of threads. In: those four. Out: numbers in [0, 1).

mod pixel_order;
mod request_key;
mod sobol;
mod window;

pub use pixel_order::PixelOrder;

use photosite_core::keys::Keys;
use photosite_core::math::hash::{first_half, hash64, unit_f32};
use request_key::request_key;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use window::Window;

/// Sampler of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum SamplerKind {
    /// Owen-scrambled Sobol points.
    // Neighbours share them in `PixelOrder`.
    Sobol,
    /// Independent random numbers: more noise, but its reported variance is exact.
    Independent,
}

/// Sampler that gives the random numbers of camera paths, dimension by dimension.
#[derive(Clone, Debug)]
pub struct Sampler {
    kind: SamplerKind,
    seed: u64,
    position: SamplePosition,
    /// Sobol points of neighbouring samples. Paths that split go to and fro between their own and those of their
    /// branches; a second window for these brought nothing.
    window: Window,
}

/// A position in the random numbers of a sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct SamplePosition {
    /// Half [`first_half`] of the key of the sequence.
    key: u64,
    /// Index of the sample in the sequence.
    index: u32,
    /// Requests so far.
    dimension: u32,
}

impl SamplePosition {
    /// The position as plain data: key, its lower half first, index, number of requests so far.
    pub fn words(self) -> [u32; 4] {
        [self.key as u32, (self.key >> 32) as u32, self.index, self.dimension]
    }

    /// Position of one of `count` paths that go on together from this position. The branches of all samples of the
    /// sequence are stratified together too.
    #[inline]
    #[must_use]
    pub fn branch(self, branch: u32, count: u32) -> Self {
        Self { index: self.index.wrapping_mul(count).wrapping_add(branch), ..self }
    }
}

impl Sampler {
    /// Makes a sampler of a render with `seed`, at no sample yet.
    pub fn new(kind: SamplerKind, seed: u64) -> Self {
        Self { kind, seed, position: SamplePosition::default(), window: Window::default() }
    }

    /// Starts sample `index` of a sequence at its first dimension.
    #[inline]
    pub fn start(&mut self, sequence: u64, index: u32) {
        self.resume(SamplePosition { key: first_half(hash64(self.seed, sequence)), index, dimension: 0 });
    }

    /// The current position.
    #[inline]
    pub fn position(&self) -> SamplePosition {
        self.position
    }

    /// Saves the position, which must be of the sample that was resumed.
    // Reading all of the position, of which a part was written last, would wait for that to reach the memory.
    #[inline]
    pub fn save(&self, position: &mut SamplePosition) {
        debug_assert_eq!(
            (position.key, position.index),
            (self.position.key, self.position.index),
            "a position of another sample"
        );
        position.dimension = self.position.dimension;
    }

    /// Resumes a sample at a position. Samples that follow each other cost least one after the other, dimension by
    /// dimension.
    #[inline]
    pub fn resume(&mut self, position: SamplePosition) {
        self.position = position;
        if self.kind == SamplerKind::Sobol {
            self.window.show(position.key, position.index);
        }
    }

    /// Draws the next random number in [0, 1).
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        self.position.dimension += 1;
        match self.kind {
            SamplerKind::Sobol => self.window.first(self.position.index, self.position.dimension),
            SamplerKind::Independent => self.independent()[0],
        }
    }

    /// Skips the dimensions that [`Self::next_1d`] or [`Self::next_2d`] would draw.
    #[inline]
    pub fn skip(&mut self) {
        self.position.dimension += 1;
    }

    /// Draws the next two random numbers in [0, 1), stratified together.
    #[inline]
    pub fn next_2d(&mut self) -> [f32; 2] {
        self.position.dimension += 1;
        match self.kind {
            SamplerKind::Sobol => self.window.both(self.position.index, self.position.dimension),
            SamplerKind::Independent => self.independent(),
        }
    }

    #[inline(never)]
    fn independent(&self) -> [f32; 2] {
        let SamplePosition { key, index, dimension } = self.position;
        let bits = hash64(request_key(key, dimension), u64::from(index));
        [unit_f32(bits as u32), unit_f32((bits >> 32) as u32)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means over 64 pixels × 256 samples of the first two dimensions.
    fn means(kind: SamplerKind) -> [f64; 2] {
        let mut sums = [0.0; 2];
        let mut sampler = Sampler::new(kind, 1);
        for pixel in 0..64 {
            for index in 0..256 {
                sampler.start(pixel, index);
                let [u, v] = sampler.next_2d();
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
        let mut sampler = Sampler::new(SamplerKind::Sobol, 5);
        for index in 0..16 {
            sampler.start(9, index);
            sampler.next_2d();
            let position = sampler.position();
            for branch in 0..4 {
                sampler.resume(position.branch(branch, 4));
                strata[(sampler.next_1d() * 64.0) as usize] += 1;
            }
        }
        assert_eq!(strata, [1; 64]);
    }

    #[test]
    fn all_requests_of_a_sample_are_independent() {
        // Two of one number and one of two: their pairs fill an 8 × 8 grid evenly, in a pixel of many samples.
        let n = 1 << 14;
        let mut counts = [[0f64; 64]; 6];
        let mut sampler = Sampler::new(SamplerKind::Sobol, 5);
        for index in 0..n {
            sampler.start(9, index);
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
        let mut sampler = Sampler::new(SamplerKind::Sobol, 5);
        for index in 0..n {
            sampler.start(9, index);
            products += (f64::from(sampler.next_1d()) - 0.5) * (f64::from(sampler.next_2d()[0]) - 0.5);
        }
        // Independent numbers: σ of the mean product = 1/12/√n = 0.00065.
        assert!((products / f64::from(n)).abs() < 4.0 * 0.00065, "{products}");
    }

    #[test]
    fn numbers_do_not_depend_on_what_was_asked_for_before() {
        for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
            // Pairs at odd requests, one number at even ones, more requests than are kept.
            let numbers = |sampler: &mut Sampler| -> Vec<f32> {
                (0..20).flat_map(|_| [sampler.next_2d(), [sampler.next_1d(), 0.0]]).flatten().collect()
            };
            let alone = |sequence: u64, index: u32| {
                let mut sampler = Sampler::new(kind, 5);
                sampler.start(sequence, index);
                numbers(&mut sampler)
            };
            let mut sampler = Sampler::new(kind, 5);
            for (sequence, index) in [(1, 0), (1, 1), (2, 1), (1, 9), (1, 8), (1, 1), (2, u32::MAX), (2, u32::MAX - 8)]
            {
                sampler.start(sequence, index);
                assert_eq!(numbers(&mut sampler), alone(sequence, index), "{kind:?}, {sequence}, {index}");
                // A first number alone, where others ask for both.
                sampler.start(sequence, index);
                let first = sampler.next_1d();
                sampler.start(sequence, index + u32::from(index % 8 == 0));
                sampler.next_2d();
                sampler.start(sequence, index);
                assert_eq!(first, sampler.next_1d(), "{kind:?}, {sequence}, {index}");
            }
        }
    }
}
