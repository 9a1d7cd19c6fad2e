//! Tests of hypotheses and sample moments, shared by the program (variance of an image) and by its tests (χ² of a
//! sampler against its density).

use std::f64::consts::PI;

/// Mean and variance of a stream of numbers, by sums in f64.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    count: u64,
    mean: f64,
    /// Sum of squared deviations from the running mean (Welford 1962).
    squares: f64,
}

impl Moments {
    /// Adds one number.
    pub fn add(&mut self, x: f64) {
        self.count += 1;
        let delta = x - self.mean;
        self.mean += delta / self.count as f64;
        self.squares += delta * (x - self.mean);
    }

    /// Number of added numbers.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean, 0 where there are no numbers.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased sample variance Σ(x − x̄)²/(n − 1), 0 for fewer than two.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { 0.0 } else { self.squares / (self.count - 1) as f64 }
    }

    /// Variance of the mean.
    pub fn variance_of_mean(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.variance() / self.count as f64 }
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        let mut moments = Self::default();
        for x in numbers {
            moments.add(x);
        }
        moments
    }
}

/// Pearson's χ² of observed counts against expected ones. Cells whose expectation is below 5 are pooled, smallest
/// first, so that the statistic follows its limiting distribution. Returns (χ², degrees of freedom).
pub fn chi_squared(observed: &[f64], expected: &[f64]) -> (f64, u32) {
    let mut cells: Vec<(f64, f64)> = expected.iter().copied().zip(observed.iter().copied()).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut statistic, mut used) = (0.0, 0u32);
    let (mut pooled_expected, mut pooled_observed) = (0.0, 0.0);
    for (expected, observed) in cells {
        if expected == 0.0 && observed > 0.0 {
            return (f64::INFINITY, 1);
        }
        pooled_expected += expected;
        pooled_observed += observed;
        if pooled_expected >= 5.0 {
            statistic += (pooled_observed - pooled_expected).powi(2) / pooled_expected;
            used += 1;
            (pooled_expected, pooled_observed) = (0.0, 0.0);
        }
    }
    (statistic, used.saturating_sub(1))
}

/// The p-value below which one of `tests` tests fails all of them, so that images that agree pass with probability 1 −
/// α: 1 − (1 − α)^(1/n). `alpha` lies in (0, 1).
///
/// Exact for independent tests. For two-sided tests of jointly normal numbers, however correlated, it errs on the side
/// of passing ([Sidak67](crate::references#sidak67)): the channels of a pixel may share their noise.
pub fn sidak_p_value(alpha: f64, tests: usize) -> f64 {
    -((-alpha).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// Kolmogorov–Smirnov: the largest distance between the distribution of a sample, sorted upwards, and the distribution
/// `cdf`; 0 for an empty sample.
pub fn kolmogorov_smirnov(sorted: &[f64], cdf: impl Fn(f64) -> f64) -> f64 {
    let n = sorted.len() as f64;
    let distance = |(i, &x): (usize, &f64)| {
        let p = cdf(x);
        ((i + 1) as f64 / n - p).max(p - i as f64 / n)
    };
    sorted.iter().enumerate().map(distance).fold(0.0, f64::max)
}

/// The probability that a sample of `n` numbers lies at least `distance` from its own distribution (Kolmogorov's limit
/// with the correction for finite n of [Stephens70](crate::references#stephens70)), good to a few percent for n > 4.
pub fn kolmogorov_smirnov_p_value(distance: f64, n: usize) -> f64 {
    let root = (n.max(1) as f64).sqrt();
    let x = (root + 0.12 + 0.11 / root) * distance;
    // Two series of the same function, each where it converges at once.
    if x < 1.18 {
        let step = (-(PI * PI) / (8.0 * x * x)).exp();
        let terms = (1..=4).map(|k| step.powi((2 * k - 1) * (2 * k - 1))).sum::<f64>();
        if x > 0.0 { 1.0 - (2.0 * PI).sqrt() / x * terms } else { 1.0 }
    } else {
        let step = (-2.0 * x * x).exp();
        2.0 * (step - step.powi(4) + step.powi(9))
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn moments_of_a_shifted_ladder() {
        let m: Moments = (0..=10).map(|i| 1e6 + f64::from(i)).collect();
        assert!((m.mean() - 1_000_005.0).abs() < 1e-9);
        assert!((m.variance() - 11.0).abs() < 1e-9);
    }

    #[test]
    fn chi_squared_by_hand() {
        // (12 − 10)²/10 + (8 − 10)²/10 = 0.8 with one degree of freedom.
        assert_eq!(chi_squared(&[12.0, 8.0], &[10.0, 10.0]), (0.8, 1));
        assert_eq!(chi_squared(&[1.0, 9.0], &[0.0, 10.0]).0, f64::INFINITY);
    }

    #[test]
    fn many_tests_pass_together_as_often_as_alpha_says() {
        for (alpha, tests) in [(0.01, 1), (0.05, 7), (0.01, 480_000), (0.5, 100_000_000)] {
            let all_pass = (tests as f64 * (-sidak_p_value(alpha, tests)).ln_1p()).exp();
            assert_relative_eq!(all_pass, 1.0 - alpha, max_relative = 1e-12);
        }
        assert_relative_eq!(sidak_p_value(0.01, 1), 0.01, max_relative = 1e-12);
    }

    #[test]
    fn distances_between_distributions_by_hand() {
        // The middles of n equal parts of 0–1 are nowhere farther than half a part away.
        let middles: Vec<f64> = (0..10).map(|i| (f64::from(i) + 0.5) / 10.0).collect();
        assert_relative_eq!(kolmogorov_smirnov(&middles, |x| x), 0.05, max_relative = 1e-12);
        // All at one end: the whole of the other end is missing.
        assert_eq!(kolmogorov_smirnov(&[0.0; 4], |x| x), 1.0);
        assert_eq!(kolmogorov_smirnov(&[1.0; 4], |x| x), 1.0);
    }

    #[test]
    fn p_values_of_distances_are_those_of_the_tables() {
        // Kolmogorov's limit: 1.3581 at 5 %, 1.6276 at 1 %, 0.8276 at 50 % (Smirnov 1948).
        for (x, p) in [(1.3581, 0.05), (1.6276, 0.01), (0.8276, 0.5)] {
            let n = 100_000_000;
            assert_relative_eq!(kolmogorov_smirnov_p_value(x / 1e4, n), p, max_relative = 1e-3);
        }
        // Exact distribution for 20 numbers (L. H. Miller, JASA 51, 1956).
        assert_relative_eq!(kolmogorov_smirnov_p_value(0.294_08, 20), 0.05, max_relative = 0.02);
        assert_relative_eq!(kolmogorov_smirnov_p_value(0.352_41, 20), 0.01, max_relative = 0.05);
        // The two series meet.
        let n = 100_000_000;
        let [below, above] = [1.179_999_9, 1.180_000_1].map(|x| kolmogorov_smirnov_p_value(x / 1e4, n));
        assert_relative_eq!(below, above, max_relative = 1e-6);
        assert_eq!(kolmogorov_smirnov_p_value(0.0, 5), 1.0);
    }
}
