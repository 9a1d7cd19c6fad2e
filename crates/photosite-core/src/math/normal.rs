//! The standard normal distribution N(0, 1).

use std::f64::consts::FRAC_1_SQRT_2;

/// Φ(z), the probability of a number up to z: ½·erfc(−z/√2).
pub fn cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// The probability of a number at least as far from 0 as z on either side: erfc(|z|/√2). Exact far out, where 2·Φ(−|z|)
/// of a Φ near 1 would be lost.
pub fn two_sided_p_value(z: f64) -> f64 {
    libm::erfc(z.abs() * FRAC_1_SQRT_2)
}

/// The |z| whose two-sided p-value is `p_value`, in (0, 1]: the inverse of [`two_sided_p_value`], by bisection.
pub fn two_sided_bound(p_value: f64) -> f64 {
    // Beyond 40 standard deviations a p-value is smaller than any number.
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if two_sided_p_value(middle) >= p_value {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The z up to which a number has the probability `p`, in (0, 1): the inverse of [`cdf`], by bisection.
pub fn quantile(p: f64) -> f64 {
    // Small probabilities have digits that those near 1 have lost.
    if p > 0.5 {
        return -quantile(1.0 - p);
    }
    let (mut low, mut high) = (-40.0, 0.0);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if cdf(middle) < p {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use statrs::distribution::{ContinuousCDF, Normal};

    use super::*;

    #[test]
    fn probabilities_are_those_of_another_implementation() {
        let reference = Normal::new(0.0, 1.0).expect("a spread above 0");
        for z in [-30.0, -6.0, -2.5, -1.0, -1e-3, 0.0, 0.5, 1.96, 4.0, 8.0] {
            assert_relative_eq!(cdf(z), reference.cdf(z), max_relative = 1e-9);
            assert_relative_eq!(two_sided_p_value(z), 2.0 * reference.cdf(-f64::abs(z)), max_relative = 1e-9);
        }
    }

    #[test]
    fn quantiles_are_those_of_another_implementation() {
        let reference = Normal::new(0.0, 1.0).expect("a spread above 0");
        for p in [1e-12, 1e-3, 0.1, 0.3, 0.5, 0.7, 0.975, 1.0 - 1e-9] {
            assert_relative_eq!(quantile(p), reference.inverse_cdf(p), max_relative = 1e-6, epsilon = 1e-9);
        }
        for z in [-30.0, -5.0, -0.1, 0.1, 5.0] {
            assert_relative_eq!(quantile(cdf(z)), z, max_relative = 1e-9);
        }
    }

    #[test]
    fn the_bound_undoes_the_p_value() {
        // Abramowitz and Stegun, table 26.6: 1.95996 at 5 %, 2.57583 at 1 %.
        assert_relative_eq!(two_sided_bound(0.05), 1.959_963_985, max_relative = 1e-9);
        assert_relative_eq!(two_sided_bound(0.01), 2.575_829_304, max_relative = 1e-9);
        for z in [0.01, 1.0, 5.6, 12.0, 37.0] {
            assert_relative_eq!(two_sided_bound(two_sided_p_value(z)), z, max_relative = 1e-9);
        }
        assert!(two_sided_bound(1.0) < 1e-12);
    }
}
