//! Figures with their standard errors.

use serde::Serialize;

/// Figure with its standard error, in the same unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Measured {
    /// Value found.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}

/// Standard errors above 0 from which on a variance counts as seen.
const SEEN: f64 = 3.0;

impl Measured {
    /// Figure with its standard error.
    pub fn new(value: f64, standard_error: f64) -> Self {
        Self { value, standard_error }
    }

    /// Figure in a unit that is `factor` times smaller.
    pub fn times(self, factor: f64) -> Self {
        Self::new(self.value * factor, self.standard_error * factor.abs())
    }

    /// Sum of independent figures.
    pub fn plus(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.standard_error.hypot(other.standard_error))
    }

    /// Difference of independent figures.
    pub fn minus(self, other: Self) -> Self {
        self.plus(other.times(-1.0))
    }

    /// Quotient of independent figures.
    pub fn over(self, other: Self) -> Self {
        let value = self.value / other.value;
        let relative = other.relative_error();
        Self::new(value, (self.standard_error / other.value).hypot(value * relative))
    }

    /// Standard error over the value.
    pub fn relative_error(self) -> f64 {
        self.standard_error / self.value.abs()
    }

    /// Root of a variance; `Err` with the bound below which it lies at 95 % where the variance is not told apart from 0.
    pub fn root(self) -> Result<Self, f64> {
        if self.value > SEEN * self.standard_error && self.value > 0.0 {
            let root = self.value.sqrt();
            return Ok(Self::new(root, self.standard_error / (2.0 * root)));
        }
        Err((self.value.max(0.0) + 1.645 * self.standard_error).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_follow_the_figures() {
        let ratio = Measured::new(6.0, 0.3).over(Measured::new(2.0, 0.1));
        // 5 % and 5 % of 3.
        assert!((ratio.value - 3.0).abs() < 1e-12 && (ratio.standard_error - 0.15 * 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(Measured::new(4.0, 0.4).root(), Ok(Measured::new(2.0, 0.1)));
        assert_eq!(Measured::new(-1.0, 1.0).root(), Err(1.645f64.sqrt()));
        assert_eq!(Measured::new(1.0, 3.0).minus(Measured::new(2.0, 4.0)), Measured::new(-1.0, 5.0));
    }
}
