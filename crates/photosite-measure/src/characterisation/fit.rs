//! Straight lines through measured points, by least squares.

/// y = offset + slope·x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Rise for each unit of x.
    pub slope: f64,
    /// Value at x = 0.
    pub offset: f64,
}

impl Line {
    /// The line's value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.offset + self.slope * x
    }
}

/// The slope of the line through the origin that fits points (x, y) best: Σxy/Σx². NaN for no points.
pub fn through_origin(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (xy, xx) = points.fold((0.0, 0.0), |(xy, xx), (x, y)| (xy + x * y, xx + x * x));
    xy / xx
}

/// The line that fits points (x, y, weight) best: it minimises Σ w·(y − offset − slope·x)². `None` where fewer than two
/// different x are given.
pub fn line(points: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Option<Line> {
    let (mut w_sum, mut x_mean, mut y_mean) = (0.0, 0.0, 0.0);
    for (x, y, w) in points.clone() {
        w_sum += w;
        x_mean += w * x;
        y_mean += w * y;
    }
    (x_mean, y_mean) = (x_mean / w_sum, y_mean / w_sum);
    // Sums around the means, so that nothing cancels however far from zero the points lie.
    let (mut xx, mut xy) = (0.0, 0.0);
    for (x, y, w) in points {
        xx += w * (x - x_mean).powi(2);
        xy += w * (x - x_mean) * (y - y_mean);
    }
    let slope = xy / xx;
    (xx > 0.0 && slope.is_finite()).then_some(Line { slope, offset: y_mean - slope * x_mean })
}

/// Standard error of the slope of a line through points (x, y) of equal weight, from their deviations:
/// √(Σ(y − line)²/(n − 2)/Σ(x − x̄)²). NaN for fewer than three points.
pub fn slope_error(fit: Line, points: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let count = points.clone().count() as f64;
    let x_mean = points.clone().map(|(x, _)| x).sum::<f64>() / count;
    let squares = points.clone().map(|(x, y)| (y - fit.at(x)).powi(2)).sum::<f64>();
    let xx = points.map(|(x, _)| (x - x_mean).powi(2)).sum::<f64>();
    if count > 2.0 { (squares / (count - 2.0) / xx).sqrt() } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn lines_by_hand() {
        // Σxy = 1·2 + 2·3 + 3·5 = 23, Σx² = 14.
        assert_relative_eq!(through_origin([(1.0, 2.0), (2.0, 3.0), (3.0, 5.0)].into_iter()), 23.0 / 14.0);
        // Slope 3/2, from the mean (2, 10/3).
        let fit = line([(1.0, 2.0, 1.0), (2.0, 3.0, 1.0), (3.0, 5.0, 1.0)].into_iter()).expect("a line");
        assert_relative_eq!(fit.slope, 1.5, max_relative = 1e-14);
        assert_relative_eq!(fit.offset, 1.0 / 3.0, max_relative = 1e-13);
        // A weight of 2 is the same point given twice.
        let twice = line([(1.0, 2.0, 1.0), (1.0, 2.0, 1.0), (2.0, 3.0, 1.0), (4.0, 5.5, 1.0)].into_iter());
        assert_eq!(line([(1.0, 2.0, 2.0), (2.0, 3.0, 1.0), (4.0, 5.5, 1.0)].into_iter()), twice);
        assert_eq!(line([(3.0, 2.0, 1.0), (3.0, 3.0, 1.0)].into_iter()), None);
    }
}
