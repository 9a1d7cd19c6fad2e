//! Shot noise: light and heat free whole electrons at random, so their number is Poisson distributed.

use rand::RngExt;
use rand::distr::Distribution;
use rand_distr::{Binomial, Poisson, StandardNormal};

use photosite_core::math::philox::Philox;

use super::frame::Frame;
use crate::sensor::signal::charge_plane::{Row, RowStage};
use crate::sensor::signal::effects::Stage;
use crate::sensor::signal::noise_key::Streams;

/// Turns mean electrons into counted ones.
#[derive(Clone, Copy, Debug)]
pub(in crate::sensor) struct ShotNoise {
    streams: Streams,
}

impl ShotNoise {
    pub(in crate::sensor) fn new(frame: &Frame<'_>) -> Option<Self> {
        frame.temporal(Stage::ShotNoise).map(|streams| Self { streams })
    }
}

impl RowStage for ShotNoise {
    /// Numbers of electrons with the Poisson distributions of their means.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        self.streams.pixels(row, |_, mean, random| poisson(f64::from(mean), random) as f32);
    }
}

/// How many of `count` electrons, each with this probability. The count is whole, not negative and far below 2⁵³, the
/// probability within 0–1.
pub(in crate::sensor) fn binomial(count: f64, probability: f64, random: &mut Philox) -> f64 {
    Binomial::new(count as u64, probability).map_or(0.0, |distribution| distribution.sample(random) as f64)
}

/// A Poisson-distributed number. `mean` is finite and not negative.
#[inline]
pub(in crate::sensor) fn poisson(mean: f64, random: &mut Philox) -> f64 {
    match Poisson::new(mean) {
        Ok(distribution) => distribution.sample(random),
        // No electrons are the only outcome of a mean of 0, for which the distribution is not defined.
        Err(_) if mean <= 0.0 => 0.0,
        // Beyond 10¹⁹ the normal distribution is the limit, to far below the spacing of f64.
        Err(_) => (mean + mean.sqrt() * random.sample::<f64, _>(StandardNormal)).round(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::NoiseKey;
    use photosite_core::math::statistics::{Moments, chi_squared};
    use statrs::distribution::{ChiSquared, ContinuousCDF, Discrete, Poisson as Reference};

    #[test]
    fn moments_are_those_of_a_poisson_distribution() {
        const N: usize = 20_000;
        let streams = NoiseKey { seed: 1, frame: 0 }.temporal(Stage::ShotNoise);
        for mean in [0.01, 0.7, 11.9, 12.1, 250.0, 1e5, 1e7] {
            let m: Moments = (0..N).map(|i| poisson(mean, &mut streams.stream(i))).collect();
            // σ of the mean: √(λ/N). Variance of the sample variance: (μ₄ − σ⁴)/N with μ₄ = λ + 3λ². 5 σ each.
            let n = N as f64;
            assert!((m.mean() - mean).abs() < 5.0 * (mean / n).sqrt(), "mean {} for {mean}", m.mean());
            let spread = ((mean + 2.0 * mean * mean) / n).sqrt();
            assert!((m.variance() - mean).abs() < 5.0 * spread, "variance {} for {mean}", m.variance());
        }
    }

    #[test]
    fn counts_follow_the_distribution() {
        const N: usize = 20_000;
        let streams = NoiseKey { seed: 2, frame: 0 }.temporal(Stage::ShotNoise);
        for mean in [0.5, 8.0, 20.0] {
            let mut observed = vec![0.0; 64];
            for i in 0..N {
                observed[(poisson(mean, &mut streams.stream(i)) as usize).min(63)] += 1.0;
            }
            let reference = Reference::new(mean).expect("a mean above 0");
            let expected: Vec<f64> = (0..64).map(|k| reference.pmf(k) * N as f64).collect();
            let (statistic, freedom) = chi_squared(&observed, &expected);
            let p = 1.0 - ChiSquared::new(f64::from(freedom)).expect("above 0").cdf(statistic);
            // The seed is fixed, so this either passes for good or the sampler is wrong.
            assert!(p > 1e-3, "mean {mean}: χ² {statistic} with {freedom} degrees of freedom, p = {p}");
        }
    }

    #[test]
    fn no_light_and_impossible_light_do_not_fail() {
        let mut random = NoiseKey::default().temporal(Stage::ShotNoise).stream(0);
        assert_eq!(poisson(0.0, &mut random), 0.0);
        assert!((poisson(1e30, &mut random) / 1e30 - 1.0).abs() < 1e-12);
    }
}
