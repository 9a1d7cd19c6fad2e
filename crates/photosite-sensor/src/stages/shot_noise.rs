//! Shot noise: light and heat free whole electrons at random, so their number is Poisson distributed.

use rand::RngExt;
use rand::distr::Distribution;
use rand_distr::{Binomial, Poisson, StandardNormal};

use photosite_core::math::philox::Philox;

use super::frame::Frame;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;
use crate::signal::words::StreamWords;

/// Turns mean electrons into counted ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShotNoise {
    streams: Streams,
}

impl ShotNoise {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        frame.temporal(Stage::ShotNoise).map(|streams| Self { streams })
    }

    /// Words of the stage.
    pub(crate) fn words(&self) -> StreamWords {
        self.streams.words()
    }
}

impl RowStage for ShotNoise {
    const MAP: NoiseMap = Stage::ShotNoise.map();

    /// Draws the electrons of each pixel from the Poisson distribution of its mean.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        self.streams.pixels(row, |_, mean, random| poisson(f64::from(mean), random) as f32);
    }
}

/// Binomial random number: successes among `count` electrons, each with this probability. The count is whole, not
/// negative and far below 2⁵³, the probability within 0–1.
pub(crate) fn binomial(count: f64, probability: f64, random: &mut Philox) -> f64 {
    Binomial::new(count as u64, probability).map_or(0.0, |distribution| distribution.sample(random) as f64)
}

/// Number of successes among `count` electrons, each with this probability: as [`binomial`] draws it, or on average
/// without random numbers.
pub(crate) fn part_of(count: f64, probability: f64, random: Option<&mut Philox>) -> f64 {
    random.map_or(count * probability, |random| binomial(count, probability, random))
}

/// A Poisson-distributed number. `mean` is finite and not negative.
#[inline]
pub(crate) fn poisson(mean: f64, random: &mut Philox) -> f64 {
    Counts::new(mean).sample(random)
}

/// Poisson distribution: the numbers that [`Poisson`] draws, without preparing for each pixel what only one in many
/// needs.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Counts {
    /// Mean of 0: no electrons.
    None,
    /// Small mean: the number is that of factors between 0 and 1 until their product passes e^(−mean) (Knuth).
    Few { e_to_minus_mean: f64 },
    /// Many: a normal number that is cut off and, rarely, corrected (Ahrens and Dieter 1982).
    Many { mean: f64 },
    /// More than f64 tells apart, for which the normal distribution is the limit.
    Normal { mean: f64 },
}

impl Counts {
    /// Least mean of [`Counts::Many`].
    const MANY: f64 = 12.0;
    /// Largest mean for which i64 holds all counts here.
    const QUICK: f64 = 1e15;

    /// Distribution of this mean, finite and not negative.
    #[inline]
    pub(crate) fn new(mean: f64) -> Self {
        if mean <= 0.0 {
            Self::None
        } else if mean < Self::MANY {
            Self::Few { e_to_minus_mean: (-mean).exp() }
        } else if mean <= Poisson::<f64>::MAX_LAMBDA {
            Self::Many { mean }
        } else {
            Self::Normal { mean }
        }
    }

    /// A number.
    #[inline]
    pub(crate) fn sample(self, random: &mut Philox) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Few { e_to_minus_mean } => {
                let (mut count, mut product) = (0.0, random.random::<f64>());
                while product > e_to_minus_mean {
                    product *= random.random::<f64>();
                    count += 1.0;
                }
                count
            }
            Self::Many { mean } => many(mean, random),
            Self::Normal { mean } => (mean + mean.sqrt() * random.sample::<f64, _>(StandardNormal)).round(),
        }
    }
}

/// Draws a number of a mean of [`Counts::MANY`] or more. The first two tests of the algorithm pass nearly all of the
/// normal numbers, and need no more than these few operations; for the others the stream begins anew, in [`Poisson`].
#[inline]
fn many(mean: f64, random: &mut Philox) -> f64 {
    if mean <= Counts::QUICK {
        let mut ahead = random.clone();
        let normal = mean + mean.sqrt() * ahead.sample::<f64, _>(StandardNormal);
        if normal >= 0.0 {
            // Cutting off is rounding down, without a call.
            let down = |x: f64| x as i64 as f64;
            let count = down(normal);
            if count >= down(mean - 1.1484) || 6.0 * mean.powi(2) * ahead.random::<f64>() >= (mean - count).powi(3) {
                *random = ahead;
                return count;
            }
        }
    }
    Poisson::new(mean).map_or(mean, |distribution| distribution.sample(random))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoiseKey;
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
    fn numbers_are_those_of_the_library_and_streams_go_on_alike() {
        let streams = NoiseKey { seed: 3, frame: 0 }.temporal(Stage::ShotNoise);
        let means = [1e-9, 0.02, 0.9, 11.99, 12.0, 12.3, 14.0, 30.0, 123.4, 5e3, 7.7e6, 9.9e14, 1.1e15, 1e19];
        for (number, mean) in means.into_iter().enumerate() {
            let distribution = Poisson::new(mean).expect("a mean that it takes");
            // Enough for each way through the algorithm: one in some hundred numbers fails both of its first tests.
            for i in 0..20_000 {
                let [mut ours, mut theirs] = [(); 2].map(|()| streams.part(number as u64).stream(i));
                assert_eq!(poisson(mean, &mut ours), distribution.sample(&mut theirs), "mean {mean}, stream {i}");
                assert_eq!(ours.random::<u64>(), theirs.random::<u64>(), "mean {mean}, stream {i}");
            }
        }
    }

    #[test]
    fn no_light_and_impossible_light_do_not_fail() {
        let mut random = NoiseKey::default().temporal(Stage::ShotNoise).stream(0);
        assert_eq!(poisson(0.0, &mut random), 0.0);
        assert!((poisson(1e30, &mut random) / 1e30 - 1.0).abs() < 1e-12);
    }
}
