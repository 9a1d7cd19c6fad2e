//! The χ² distribution of k degrees of freedom: the sum of k squared standard normal variables.

/// The probability of a χ² up to `value`: P(k/2, χ²/2), the regularised lower incomplete gamma function.
pub fn cdf(value: f64, freedom: f64) -> f64 {
    let [lower, _] = incomplete_gamma(0.5 * freedom, 0.5 * value);
    lower
}

/// The probability of a χ² above `value`, exact far out, where 1 − [`cdf`] would be lost: the p-value.
pub fn survival(value: f64, freedom: f64) -> f64 {
    let [_, upper] = incomplete_gamma(0.5 * freedom, 0.5 * value);
    upper
}

/// Density of s = √(χ²/k), the ratio of a standard deviation estimated with k degrees of freedom to the true one:
/// 2·(k/2)^(k/2)/Γ(k/2)·s^(k−1)·exp(−k·s²/2).
pub fn density_of_sigma(s: f64, freedom: f64) -> f64 {
    if s <= 0.0 {
        return 0.0;
    }
    let half = 0.5 * freedom;
    2.0 * (half * half.ln() - libm::lgamma(half) + (freedom - 1.0) * s.ln() - half * s * s).exp()
}

/// P(a, x) and Q(a, x) = 1 − P, neither computed from the other: the series of [Dlmf](crate::references#dlmf) 8.11.4
/// below a + 1, and above it the continued fraction 8.9.2 by Lentz's method. Both take about √a terms near x = a.
fn incomplete_gamma(a: f64, x: f64) -> [f64; 2] {
    if x.is_nan() || x <= 0.0 {
        return [0.0, 1.0];
    }
    if x.is_infinite() {
        return [1.0, 0.0];
    }
    let front = (a * x.ln() - x - libm::lgamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * f64::EPSILON {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        let lower = front * sum;
        return [lower, 1.0 - lower];
    }
    const TINY: f64 = 1e-300;
    let not_nothing = |y: f64| if y.abs() < TINY { TINY } else { y };
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1.0 / TINY, 1.0 / not_nothing(b));
    let (mut fraction, mut n) = (d, 0.0);
    loop {
        n += 1.0;
        let numerator = -n * (n - a);
        b += 2.0;
        d = 1.0 / not_nothing(numerator * d + b);
        c = not_nothing(b + numerator / c);
        let factor = c * d;
        fraction *= factor;
        if (factor - 1.0).abs() < 4.0 * f64::EPSILON {
            break;
        }
    }
    let upper = front * fraction;
    [1.0 - upper, upper]
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    use super::*;

    #[test]
    fn probabilities_are_those_of_another_implementation() {
        for freedom in [1.0, 2.0, 3.0, 30.0, 253.0, 65_533.0, 8e6] {
            let reference = ChiSquared::new(freedom).expect("above 0");
            for sigmas in [-6.0, -2.0, -0.5, 0.0, 0.1, 1.0, 3.0, 8.0] {
                let value = freedom + sigmas * (2.0f64 * freedom).sqrt();
                // Logarithms of up to 1e8 are rounded to 2⁻⁵³ of themselves.
                let within = 1e-11 + freedom * 1e-14;
                assert_relative_eq!(cdf(value, freedom), reference.cdf(value), max_relative = within);
                if value > 0.0 {
                    assert_relative_eq!(survival(value, freedom), reference.sf(value), max_relative = within.max(1e-9));
                }
            }
        }
        assert_eq!((cdf(0.0, 5.0), survival(f64::INFINITY, 5.0)), (0.0, 0.0));
        // Two degrees of freedom: an exponential distribution, far out.
        assert_relative_eq!(survival(600.0, 2.0), (-300.0f64).exp(), max_relative = 1e-12);
    }

    #[test]
    fn the_density_of_a_standard_deviation_is_the_slope_of_its_distribution() {
        for freedom in [1.0, 4.0, 46.0, 1000.0] {
            for s in [0.3, 0.9, 1.0, 1.2] {
                let step = 1e-5;
                let cdf = |s: f64| cdf(freedom * s * s, freedom);
                let slope = (cdf(s + step) - cdf(s - step)) / (2.0 * step);
                assert!((slope - density_of_sigma(s, freedom)).abs() < 1e-5 * (1.0 + slope), "{freedom} {s}");
            }
        }
    }
}
