//! Distribution of standard deviations, each found from a few pixel values, beside the one expected if all were of the
//! same noise.

use serde::Serialize;

use photosite_core::math::chi_squared;
use photosite_core::math::statistics::{kolmogorov_smirnov, kolmogorov_smirnov_p_value};

/// Standard deviations σ̂ that were found with k degrees of freedom each. Of normally distributed noise of one σ,
/// k·σ̂²/σ² follows χ² with k degrees of freedom, so that σ̂ follows σ·√(χ²/k).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SigmaDistribution {
    /// Number of standard deviations.
    pub count: usize,
    /// k.
    pub freedom: f64,
    /// σ that all are compared with: the root of the mean of σ̂², or the one that is known.
    pub sigma: f64,
    /// Mean of σ̂.
    pub mean: f64,
    /// Median of σ̂.
    pub median: f64,
    /// Smallest of σ̂.
    pub smallest: f64,
    /// Largest of σ̂.
    pub largest: f64,
    /// Standard deviation of σ̂.
    pub spread: f64,
    /// Expected standard deviation of σ̂: that of σ·√(χ²/k), about σ/√(2k).
    pub expected_spread: f64,
    /// Largest distance of their distribution from that of σ·√(χ²/k) (Kolmogorov–Smirnov).
    pub distance: f64,
    /// Probability of so large a distance if all are of one normal noise; where σ was found from them, it errs towards
    /// 1.
    pub p_value: f64,
    /// All σ̂, from the smallest on.
    #[serde(skip)]
    pub sorted: Vec<f64>,
}

impl SigmaDistribution {
    /// Distribution of at least one σ̂, compared with noise of `sigma`.
    pub(super) fn new(mut sigmas: Vec<f64>, freedom: f64, sigma: f64) -> Self {
        sigmas.sort_unstable_by(f64::total_cmp);
        let count = sigmas.len();
        let mean = sigmas.iter().sum::<f64>() / count as f64;
        let spread = (sigmas.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / count as f64).sqrt();
        let distance = if sigma > 0.0 {
            kolmogorov_smirnov(&sigmas, |s| chi_squared::cdf(freedom * (s / sigma).powi(2), freedom))
        } else {
            0.0
        };
        Self {
            count,
            freedom,
            sigma,
            mean,
            median: 0.5 * (sigmas[(count - 1) / 2] + sigmas[count / 2]),
            smallest: sigmas[0],
            largest: sigmas[count - 1],
            spread,
            expected_spread: sigma * (1.0 - mean_of_root(freedom).powi(2)).max(0.0).sqrt(),
            distance,
            p_value: kolmogorov_smirnov_p_value(distance, count),
            sorted: sigmas,
        }
    }

    /// Density of σ·√(χ²/k) at `sigma`.
    pub fn expected_density(&self, sigma: f64) -> f64 {
        if self.sigma > 0.0 {
            chi_squared::density_of_sigma(sigma / self.sigma, self.freedom) / self.sigma
        } else {
            0.0
        }
    }
}

/// Mean of √(χ²/k): √(2/k)·Γ((k + 1)/2)/Γ(k/2).
fn mean_of_root(freedom: f64) -> f64 {
    (2.0 / freedom).sqrt() * (libm::lgamma(0.5 * (freedom + 1.0)) - libm::lgamma(0.5 * freedom)).exp()
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use super::*;
    use photosite_core::math::philox::Philox;

    /// Standard deviations of `freedom` normal numbers each, the first part with another σ.
    fn sigmas(freedom: usize, count: usize, sigma: impl Fn(usize) -> f64) -> Vec<f64> {
        let of = |i: usize| {
            let mut random = Philox::new(11, i as u64);
            let squares: f64 = (0..freedom).map(|_| random.sample::<f64, _>(StandardNormal).powi(2)).sum();
            sigma(i) * (squares / freedom as f64).sqrt()
        };
        (0..count).map(of).collect()
    }

    #[test]
    fn noise_of_one_sigma_follows_chi_squared_and_of_two_does_not() {
        for freedom in [1, 4, 46] {
            let found = SigmaDistribution::new(sigmas(freedom, 4000, |_| 3.0), freedom as f64, 3.0);
            assert!(found.p_value > 1e-3, "{freedom}: {}", found.p_value);
            // The spread of 4000 is known to 1/√(2·4000) of itself, more for a long tail; 5 of them.
            assert!((found.spread / found.expected_spread - 1.0).abs() < 0.08, "{}", found.spread);
            let mean = 3.0 * mean_of_root(freedom as f64);
            assert!((found.mean - mean).abs() < 5.0 * found.spread / 4000f64.sqrt(), "{}", found.mean);
            let mixed = sigmas(freedom, 4000, |i| if i % 2 == 0 { 1.0 } else { 3.0 });
            let found = SigmaDistribution::new(mixed, freedom as f64, 5f64.sqrt());
            assert!(found.p_value < 1e-6, "{freedom}: {}", found.p_value);
        }
    }

    #[test]
    fn images_without_noise_have_no_distribution() {
        let found = SigmaDistribution::new(vec![0.0; 5], 3.0, 0.0);
        assert_eq!((found.distance, found.p_value, found.expected_density(1.0)), (0.0, 1.0, 0.0));
    }
}
