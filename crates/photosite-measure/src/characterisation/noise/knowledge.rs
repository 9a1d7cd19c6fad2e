//! Knowledge of an image besides its pixel values.

/// Knowledge of an image besides its pixel values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Knowledge {
    /// Value of no signal.
    pub black: f64,
    /// Value of the largest signal.
    pub white: Option<f64>,
    /// Distance between neighbouring values, where they were rounded.
    pub step: Option<f64>,
    /// Variance that each pixel should have.
    pub variance: Option<f64>,
}
