//! Lines through figures with standard errors.

use super::measured::Measured;

/// Line y = offset + slope·x through measured points, with the errors of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredLine {
    /// Rise for each unit of x.
    pub slope: Measured,
    /// Value at x = 0.
    pub offset: Measured,
    /// Mean of x, at which the line is known best.
    x_mean: f64,
    at_mean: Measured,
}

impl MeasuredLine {
    /// Value at `x`.
    pub(super) fn at(&self, x: f64) -> Measured {
        self.at_mean.plus(self.slope.times(x - self.x_mean))
    }

    /// Line of least squares with weights 1/error². `None` for fewer than two different x.
    pub(super) fn through(points: &[(f64, Measured)]) -> Option<Self> {
        let weight = |y: &Measured| y.standard_error.powi(-2);
        let total: f64 = points.iter().map(|(_, y)| weight(y)).sum();
        let mean =
            |of: &dyn Fn(&(f64, Measured)) -> f64| points.iter().map(|p| weight(&p.1) * of(p)).sum::<f64>() / total;
        let (x_mean, y_mean) = (mean(&|p| p.0), mean(&|p| p.1.value));
        let xx: f64 = points.iter().map(|(x, y)| weight(y) * (x - x_mean).powi(2)).sum();
        let xy: f64 = points.iter().map(|(x, y)| weight(y) * (x - x_mean) * (y.value - y_mean)).sum();
        let slope = xy / xx;
        if !(xx > 0.0 && slope.is_finite() && y_mean.is_finite()) {
            return None;
        }
        let residuals = points.iter().map(|(x, y)| (y.value - y_mean - slope * (x - x_mean)) / y.standard_error);
        let scale = scatter(residuals, 2);
        let slope = Measured::new(slope, scale * xx.powf(-0.5));
        let at_mean = Measured::new(y_mean, scale * total.powf(-0.5));
        Some(Self { slope, offset: at_mean.minus(slope.times(x_mean)), x_mean, at_mean })
    }
}

/// Slope of the line through the origin, by least squares with weights 1/error². NaN for no points.
pub(super) fn slope_through_origin(points: &[(f64, Measured)]) -> Measured {
    let weight = |y: &Measured| y.standard_error.powi(-2);
    let xx: f64 = points.iter().map(|(x, y)| weight(y) * x * x).sum();
    let slope = points.iter().map(|(x, y)| weight(y) * x * y.value).sum::<f64>() / xx;
    let residuals = points.iter().map(|(x, y)| (y.value - slope * x) / y.standard_error);
    Measured::new(slope, scatter(residuals, 1) * xx.powf(-0.5))
}

/// Mean of measurements of one figure, with weights that are given: those of their errors would prefer values that are
/// too small by chance, where errors follow values.
pub(super) fn weighted_mean(values: impl Iterator<Item = (Measured, f64)> + Clone) -> Measured {
    let total: f64 = values.clone().map(|(_, weight)| weight).sum();
    let mean = values.clone().map(|(m, weight)| weight * m.value).sum::<f64>() / total;
    let error = values.map(|(m, weight)| (weight * m.standard_error).powi(2)).sum::<f64>().sqrt() / total;
    Measured::new(mean, error)
}

/// Factor by which deviations, in standard errors, are larger than chance explains; 1 where it does. `fitted` figures
/// were taken from the points. χ² of f degrees of freedom is f ± √(2f); what goes three of that beyond is not chance but
/// something that the errors do not know, such as light that drifts, and they are widened to match.
fn scatter(deviations: impl Iterator<Item = f64>, fitted: usize) -> f64 {
    let (count, squares) = deviations.fold((0usize, 0.0), |(n, sum), z| (n + 1, sum + z * z));
    if count <= fitted {
        return 1.0;
    }
    let freedom = (count - fitted) as f64;
    if squares > freedom + 3.0 * (2.0 * freedom).sqrt() { (squares / freedom).sqrt() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_by_hand() {
        let y = |value| Measured::new(value, 0.1);
        // Σ(x − 2)² = 2 of weight 100: errors 0.1/√2 and 0.1/√3 at the mean; at 0 √(0.1²/3 + (2·0.1)²/2).
        let line = MeasuredLine::through(&[(1.0, y(2.0)), (2.0, y(3.1)), (3.0, y(4.0))]).expect("a line");
        assert!((line.slope.value - 1.0).abs() < 1e-12 && (line.offset.value - 1.0333333).abs() < 1e-6);
        assert!((line.slope.standard_error - 0.1 / 2f64.sqrt()).abs() < 1e-12);
        assert!((line.offset.standard_error - (0.01f64 / 3.0 + 0.02).sqrt()).abs() < 1e-12);
        assert!((line.at(2.0).standard_error - 0.1 / 3f64.sqrt()).abs() < 1e-12);
        assert_eq!(MeasuredLine::through(&[(1.0, y(2.0)), (1.0, y(3.0))]), None);
        let slope = slope_through_origin(&[(1.0, y(2.0)), (2.0, y(4.0))]);
        assert!((slope.value - 2.0).abs() < 1e-12 && (slope.standard_error - 0.1 / 5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn errors_grow_where_points_scatter_more_than_they_say() {
        let point = |x: i32| (f64::from(x), Measured::new(f64::from(x % 2), 0.01));
        let points: Vec<_> = (1..=20).map(point).collect();
        let line = MeasuredLine::through(&points).expect("a line");
        // Deviations of ½ instead of 0.01.
        let alone =
            MeasuredLine::through(&points.iter().map(|(x, _)| (*x, Measured::new(0.0, 0.01))).collect::<Vec<_>>());
        let factor = line.slope.standard_error / alone.expect("a line").slope.standard_error;
        assert!((45.0..60.0).contains(&factor), "{factor}");
    }
}
