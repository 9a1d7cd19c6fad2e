//! How far pictures may lie apart.

use super::compare::Comparison;

/// The most that any channel may differ by; `None` leaves it open.
#[derive(Clone, Debug, Default)]
pub struct Limits {
    /// Of |mean of a − b|, in percent of the mean of b.
    pub mean_difference_percent: Option<f64>,
    /// Of the root of the mean squared error, in the pictures' unit.
    pub rmse: Option<f64>,
    /// Of the relative mean squared error.
    pub relative_mse: Option<f64>,
}

impl Limits {
    /// Whether there is no limit.
    pub fn is_empty(&self) -> bool {
        self.mean_difference_percent.is_none() && self.rmse.is_none() && self.relative_mse.is_none()
    }
}

/// What speaks against taking the pictures for the same, a sentence each: pixels that are no numbers, those that noise
/// does not explain, and what is past a limit. Empty if nothing does.
pub fn failures(comparison: &Comparison, limits: &Limits) -> Vec<String> {
    let mut failures = Vec::new();
    for c in &comparison.channels {
        let name = &c.channel;
        if c.non_finite > 0 {
            failures.push(format!("{name}: {} of {} pixels are not finite", c.non_finite, c.pixels));
        }
        for (what, value, unit, limit) in [
            ("mean difference", c.mean_difference_percent.abs(), " %", limits.mean_difference_percent),
            ("RMSE", c.rmse, "", limits.rmse),
            ("relative MSE", c.relative_mse, "", limits.relative_mse),
        ] {
            // Not-a-number is past every limit.
            if let Some(limit) = limit.filter(|&limit| value.is_nan() || value > limit) {
                failures.push(format!("{name}: {what} {value:.4}{unit} is past the limit of {limit}{unit}"));
            }
        }
    }
    if let Some(v) = comparison.verdict.as_ref().filter(|v| !v.agree) {
        let (past, tests, z, alpha) = (v.past_bound, v.tests, v.z_bound, v.alpha);
        failures.push(format!("noise does not explain {past} of {tests} z-scores: |z| > {z:.2} (Šidák, α = {alpha})"));
    }
    failures
}
