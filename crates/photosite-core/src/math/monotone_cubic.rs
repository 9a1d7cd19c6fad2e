//! Curves through points that rise or fall wherever the points do.

/// A piecewise cubic through points, with continuous slope and without overshoot: between two points it stays between
/// their values ([FritschCarlson80](crate::references#fritschcarlson80), with the slopes of
/// [FritschButland84](crate::references#fritschbutland84)). Beyond its ends it is linear.
#[derive(Clone, Debug, PartialEq)]
pub struct MonotoneCubic {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl MonotoneCubic {
    /// The curve through points whose x rise; `None` where they do not, where there are none, or where their number is
    /// not that of y.
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Option<Self> {
        let rises = x.windows(2).all(|pair| pair[0] < pair[1]);
        if x.is_empty() || x.len() != y.len() || !rises || !x.iter().chain(&y).all(|value| value.is_finite()) {
            return None;
        }
        let last = x.len() - 1;
        let secant = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
        // At an end, of the parabola through the three points there, as far as it is monotone.
        let at_end = |near: usize, far: usize| {
            let (h, next) = (x[near + 1] - x[near], x[far + 1] - x[far]);
            let slope = ((2.0 * h + next) * secant(near) - h * secant(far)) / (h + next);
            let turns = secant(near) * secant(far) <= 0.0;
            if slope * secant(near) <= 0.0 {
                0.0
            } else if turns && slope.abs() > 3.0 * secant(near).abs() {
                3.0 * secant(near)
            } else {
                slope
            }
        };
        // Elsewhere a harmonic mean of both sides, weighed by the widths.
        let inside = |i: usize| {
            let (before, behind) = (secant(i - 1), secant(i));
            let (h, next) = (x[i] - x[i - 1], x[i + 1] - x[i]);
            let (w1, w2) = (2.0 * next + h, next + 2.0 * h);
            if before * behind <= 0.0 { 0.0 } else { (w1 + w2) / (w1 / before + w2 / behind) }
        };
        let slope = |i: usize| match last {
            0 => 0.0,
            1 => secant(0),
            _ if i == 0 => at_end(0, 1),
            _ if i == last => at_end(last - 1, last - 2),
            _ => inside(i),
        };
        let slope = (0..=last).map(slope).collect();
        Some(Self { x, y, slope })
    }

    /// The value at x.
    pub fn eval(&self, x: f64) -> f64 {
        let last = self.x.len() - 1;
        if x <= self.x[0] || last == 0 {
            return self.y[0] + self.slope[0] * (x - self.x[0]);
        }
        if x >= self.x[last] {
            return self.y[last] + self.slope[last] * (x - self.x[last]);
        }
        let i = self.x.partition_point(|start| *start <= x) - 1;
        let h = self.x[i + 1] - self.x[i];
        let t = (x - self.x[i]) / h;
        let (t2, t3) = (t * t, t * t * t);
        self.y[i] * (2.0 * t3 - 3.0 * t2 + 1.0)
            + self.slope[i] * h * (t3 - 2.0 * t2 + t)
            + self.y[i + 1] * (3.0 * t2 - 2.0 * t3)
            + self.slope[i + 1] * h * (t3 - t2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected values are of SciPy 1.17, `PchipInterpolator([0, 1, 3, 4, 7], [0, 2, 2.5, 7, 6])`.
    #[test]
    fn values_are_those_of_scipys_pchip() {
        let curve = MonotoneCubic::new(vec![0.0, 1.0, 3.0, 4.0, 7.0], vec![0.0, 2.0, 2.5, 7.0, 6.0]).expect("rises");
        let of_scipy = [
            (0.25, 0.6529771959459459),
            (1.0, 2.0),
            (2.2, 2.265924885924886),
            (3.7, 6.061136363636365),
            (4.1, 6.999962962962963),
            (6.5, 6.421296296296296),
        ];
        for (x, expected) in of_scipy {
            assert!((curve.eval(x) - expected).abs() < 1e-12, "{x}: {} {expected}", curve.eval(x));
        }
    }

    #[test]
    fn few_points_and_wrong_ones() {
        let constant = MonotoneCubic::new(vec![2.0], vec![5.0]).expect("a point");
        assert_eq!([constant.eval(0.0), constant.eval(9.0)], [5.0, 5.0]);
        let line = MonotoneCubic::new(vec![0.0, 2.0], vec![1.0, 5.0]).expect("a line");
        assert_eq!([line.eval(-1.0), line.eval(0.5), line.eval(3.0)], [-1.0, 2.0, 7.0]);
        for (x, y) in
            [(vec![], vec![]), (vec![1.0, 1.0], vec![0.0, 1.0]), (vec![1.0], vec![]), (vec![f64::NAN], vec![0.0])]
        {
            assert_eq!(MonotoneCubic::new(x, y), None);
        }
    }
}
