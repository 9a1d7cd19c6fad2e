//! A positive curve by its prior and a few linear measurements of it.

use photosite_core::math::linear::{Cholesky, solve};

/// Prior of a curve: its logarithm is a normal process, so that the curve is positive and its flanks are as steep where it is small.
/// Dyes, filters and silicon multiply.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogProcess {
    /// Mean of the logarithm.
    pub(super) mean: f64,
    /// Standard deviation of the logarithm.
    pub(super) deviation: f64,
    /// Length l of the correlation (1 + r)·e^(−r), r = √3·Δ/l, of places that are Δ apart (Matérn, ν = 3/2).
    pub(super) length: f64,
}

/// Measurements y = A·q of a curve with independent errors.
pub(super) struct Measurements<'a> {
    /// Weights A of the curve's values, a row for each measurement.
    pub(super) weights: &'a [Vec<f64>],
    /// Measured values.
    pub(super) values: &'a [f64],
    /// Their standard errors.
    pub(super) errors: &'a [f64],
}

/// Curve that explains measurements best.
pub(super) struct Posterior {
    /// Values of the curve.
    pub(super) curve: Vec<f64>,
    /// Standard errors of the logarithms.
    pub(super) log_errors: Vec<f64>,
    /// Logarithm of the probability of the measurements under the prior, by Laplace's approximation, up to a constant.
    pub(super) evidence: f64,
}

impl LogProcess {
    /// Factor L of the covariance L·Lᵀ of the logarithms at these places; whitened coefficients z make the logarithms
    /// mean + L·z.
    pub(super) fn factor(&self, places: &[f64]) -> Vec<Vec<f64>> {
        let covariance = |a: f64, b: f64| {
            let r = 3f64.sqrt() * (a - b).abs() / self.length;
            // The diagonal stays above rounding.
            self.deviation.powi(2) * ((1.0 + r) * (-r).exp() + if a == b { 1e-9 } else { 0.0 })
        };
        let rows = places.iter().map(|&a| places.iter().map(|&b| covariance(a, b)).collect()).collect();
        Cholesky::new(rows).expect("a covariance").lower
    }

    /// The most probable curve, by Gauss's and Newton's steps with Levenberg's damping on ½|z|² + ½Σ((y − A·q)/σ)², and the
    /// spread about it by its curvature H = 1 + JᵀJ (Laplace's approximation).
    pub(super) fn posterior(&self, factor: &[Vec<f64>], measured: &Measurements<'_>) -> Posterior {
        const STEPS: usize = 60;
        let n = factor.len();
        let curve = |z: &[f64]| -> Vec<f64> {
            let logarithm = |row: &Vec<f64>| self.mean + row.iter().zip(z).map(|(l, z)| l * z).sum::<f64>();
            factor.iter().map(|row| logarithm(row).clamp(-30.0, 30.0).exp()).collect()
        };
        let residuals = |q: &[f64]| -> Vec<f64> {
            let of = |(row, (y, error)): (&Vec<f64>, (&f64, &f64))| (y - dot(row, q)) / error;
            measured.weights.iter().zip(measured.values.iter().zip(measured.errors)).map(of).collect()
        };
        let cost = |z: &[f64], r: &[f64]| 0.5 * (dot(z, z) + dot(r, r));
        // ∂(A·q/σ)/∂z = A·diag(q)·L/σ.
        let jacobian = |q: &[f64]| -> Vec<Vec<f64>> {
            let row = |(weights, error): (&Vec<f64>, &f64)| {
                let mut line = vec![0.0; n];
                for ((weight, value), factors) in weights.iter().zip(q).zip(factor) {
                    let by = weight * value / error;
                    line.iter_mut().zip(factors).for_each(|(to, l)| *to += by * l);
                }
                line
            };
            measured.weights.iter().zip(measured.errors).map(row).collect()
        };
        let curvature = |j: &[Vec<f64>], damping: f64| -> Vec<Vec<f64>> {
            let mut h = vec![vec![0.0; n]; n];
            for line in j {
                for (row, a) in h.iter_mut().zip(line) {
                    row.iter_mut().zip(line).for_each(|(to, b)| *to += a * b);
                }
            }
            h.iter_mut().enumerate().for_each(|(i, row)| row[i] += damping);
            h
        };
        let mut z = vec![0.0; n];
        let mut q = curve(&z);
        let mut r = residuals(&q);
        let (mut least, mut damping) = (cost(&z, &r), 1.0);
        for _ in 0..STEPS {
            let j = jacobian(&q);
            let downhill = (0..n).map(|i| j.iter().zip(&r).map(|(line, r)| line[i] * r).sum::<f64>() - z[i]).collect();
            let Some(step) = solve(curvature(&j, damping), downhill) else { break };
            let next: Vec<f64> = z.iter().zip(&step).map(|(z, step)| z + step).collect();
            let next_curve = curve(&next);
            let next_residuals = residuals(&next_curve);
            let next_cost = cost(&next, &next_residuals);
            if next_cost < least {
                let gain = least - next_cost;
                (z, q, r, least) = (next, next_curve, next_residuals, next_cost);
                damping = f64::max(1.0, damping / 3.0);
                if gain < 1e-7 {
                    break;
                }
            } else {
                damping *= 4.0;
            }
        }
        let of_curvature = Cholesky::new(curvature(&jacobian(&q), 1.0)).expect("1 and more on the diagonal");
        let log_errors = factor.iter().map(|row| of_curvature.inverse_norm(row)).collect();
        let of_errors: f64 = measured.errors.iter().map(|error| error.ln()).sum();
        Posterior { curve: q, log_errors, evidence: -least - 0.5 * of_curvature.log_determinant() - of_errors }
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_measured_is_found_and_the_rest_is_the_prior() {
        let places: Vec<f64> = (0..30).map(f64::from).collect();
        let prior = LogProcess { mean: -1.0, deviation: 1.5, length: 4.0 };
        let factor = prior.factor(&places);
        // Single values of the first half.
        let weights: Vec<Vec<f64>> = (0..15).map(|i| (0..30).map(|j| f64::from(u8::from(i == j))).collect()).collect();
        let values: Vec<f64> = (0..15).map(|i| 0.2 + 0.1 * f64::from(i)).collect();
        let measured = Measurements { weights: &weights, values: &values, errors: &[1e-3; 15] };
        let Posterior { curve, log_errors, .. } = prior.posterior(&factor, &measured);
        for ((found, error), value) in curve.iter().zip(&log_errors).zip(&values) {
            assert!((found - value).abs() < 3e-3 && (error * found - 1e-3).abs() < 2e-4, "{found} {error} {value}");
        }
        assert!((curve[29] - (-1f64).exp()).abs() < 0.02 && (log_errors[29] - 1.5).abs() < 0.01, "{}", curve[29]);
    }
}
