//! Tests of hypotheses and sample moments, shared by the program (variance of a picture) and by its tests (χ² of a
//! sampler against its density).

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

    /// How many numbers were added.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean, 0 for none.
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

#[cfg(test)]
mod tests {
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
}
