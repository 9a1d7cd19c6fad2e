//! Limits of the difference between images.

use super::compare::Comparison;

/// The most that any channel may differ by; `None` leaves it open.
#[derive(Clone, Debug, Default)]
pub struct Limits {
    /// Limit of |mean of a − b|, in percent of the mean of b.
    pub mean_difference_percent: Option<f64>,
    /// Limit of the root of the mean squared error, in the images' unit.
    pub rmse: Option<f64>,
    /// Limit of the relative mean squared error.
    pub relative_mse: Option<f64>,
}

impl Limits {
    /// Whether there is no limit.
    pub fn is_empty(&self) -> bool {
        self.mean_difference_percent.is_none() && self.rmse.is_none() && self.relative_mse.is_none()
    }
}

/// Reasons against taking the images for the same, a sentence each: pixels that are no numbers, those that noise does
/// not explain, and figures past a limit. Empty where there are none.
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
    if let Some(v) = &comparison.verdict {
        let bound = format!("|z| > {:.2} (Šidák, α = {}, {} tests)", v.z_bound, v.alpha, v.tests);
        if v.pixels_past_bound > 0 {
            let pixels = if v.pixels_past_bound == 1 { "pixel" } else { "pixels" };
            // Where the means agree, the variances are in doubt before the images are.
            let doubt = if v.channels_past_bound.is_empty() {
                "; the means agree: look for images that do not lie on each other; variances of few samples are uncertain, too"
            } else {
                ""
            };
            failures.push(format!("noise does not explain {} {pixels}: {bound}{doubt}", v.pixels_past_bound));
        }
        if !v.channels_past_bound.is_empty() {
            failures.push(format!("noise does not explain the mean of {}: {bound}", v.channels_past_bound.join(", ")));
        }
    }
    failures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validation::compared_image::tests::image;
    use crate::validation::{ComparisonSettings, compare};

    #[test]
    fn limits_hold_up_to_themselves() {
        // A mean difference of −50 %, an RMSE of 2, a relative MSE of 4/(16 + 16).
        let (a, b) = (image(1, 1, &[("Y", &[2.0])]), image(1, 1, &[("Y", &[4.0])]));
        let comparison =
            compare(&a, &b, &ComparisonSettings { epsilon: 1.0, ..ComparisonSettings::default() }).expect("comparable");
        let limits = |factor: f64| {
            let limit = |x: f64| Some(x * factor);
            Limits { mean_difference_percent: limit(50.0), rmse: limit(2.0), relative_mse: limit(0.125) }
        };
        assert_eq!(failures(&comparison, &limits(1.0)), [""; 0]);
        let failed = failures(&comparison, &limits(0.999));
        assert_eq!(failed.len(), 3);
        assert_eq!(failed[0], "Y: mean difference 50.0000 % is past the limit of 49.95 %");
        assert_eq!(failures(&comparison, &Limits::default()), [""; 0]);
        assert!(Limits::default().is_empty() && !limits(1.0).is_empty());
    }

    #[test]
    fn what_is_no_number_is_past_every_limit() {
        let a = image(1, 1, &[("Y", &[f32::NAN])]);
        let comparison = compare(&a, &a, &ComparisonSettings::default()).expect("comparable");
        assert_eq!(failures(&comparison, &Limits::default()), ["Y: 1 of 1 pixels are not finite"]);
        let limits = Limits { rmse: Some(f64::MAX), ..Limits::default() };
        assert_eq!(failures(&comparison, &limits).len(), 2);
    }

    #[test]
    fn noise_that_explains_nothing_is_told() {
        let a = image(1, 1, &[("Y", &[9.0])]).with_variances(&[("Y", &[1.0])]);
        let b = image(1, 1, &[("Y", &[0.0])]).with_constant_variance(0.0);
        let failed =
            failures(&compare(&a, &b, &ComparisonSettings::default()).expect("comparable"), &Limits::default());
        assert!(failed[0].starts_with("noise does not explain 1 pixel: |z| > 2.81"), "{failed:?}");
        assert!(failed[1].starts_with("noise does not explain the mean of Y: |z| > 2.81"), "{failed:?}");
    }
}
