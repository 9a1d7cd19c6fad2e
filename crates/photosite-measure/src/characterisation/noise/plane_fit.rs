//! Noise of a patch with linear shading: what a plane leaves.

use serde::Serialize;

use super::patch::{Patch, Variance};
use photosite_core::math::chi_squared;

/// The plane y = c + a·x + b·y through a patch by least squares, and what it leaves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlaneFit {
    /// a and b: rise per pixel along x and y.
    pub slope: [f64; 2],
    /// Variance of what is left, Σr²/(n − 3).
    pub noise: Variance,
    /// Whether noise of the known variance explains what is left.
    pub chi_squared: Option<ChiSquared>,
}

/// χ² = Σr²/σ² of residuals r whose variance σ² is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChiSquared {
    /// χ².
    pub value: f64,
    /// Degrees of freedom: n − 3 of each plane.
    pub freedom: f64,
    /// χ² over its degrees of freedom: 1 ± √(2/freedom) where noise explains all.
    pub reduced: f64,
    /// Probability of so large a χ² if noise explains all.
    pub p_value: f64,
}

impl PlaneFit {
    /// Fits a plane and returns the fit with its residuals. The columns and rows of a patch are so even that the three
    /// parameters do not depend on each other: around the middle, a = Σx·y/Σx².
    pub(super) fn new(patch: &Patch, known_variance: Option<f64>) -> (Self, Vec<f64>) {
        let Patch { width, height, ref values } = *patch;
        let middle = [width, height].map(|n| (n - 1) as f64 / 2.0);
        let place = |i: usize| [(i % width) as f64 - middle[0], (i / width) as f64 - middle[1]];
        let pixels = values.len() as f64;
        let mean = patch.mean();
        let mut slope = [0.0; 2];
        for (i, y) in values.iter().enumerate() {
            let at = place(i);
            slope[0] += at[0] * (y - mean);
            slope[1] += at[1] * (y - mean);
        }
        // Σ(x − x̄)² of N whole numbers is N·(N² − 1)/12.
        let squares = |side: usize| pixels * ((side * side - 1) as f64) / 12.0;
        slope = [slope[0] / squares(width), slope[1] / squares(height)];
        let residual = |(i, y): (usize, &f64)| y - mean - slope[0] * place(i)[0] - slope[1] * place(i)[1];
        let residuals: Vec<f64> = values.iter().enumerate().map(residual).collect();
        let left: f64 = residuals.iter().map(|r| r * r).sum();
        let freedom = pixels - 3.0;
        let chi_squared = known_variance.filter(|&v| v > 0.0).map(|variance| ChiSquared::new(left / variance, freedom));
        (Self { slope, noise: Variance::of(left, freedom), chi_squared }, residuals)
    }
}

impl ChiSquared {
    pub(super) fn new(value: f64, freedom: f64) -> Self {
        Self { value, freedom, reduced: value / freedom, p_value: chi_squared::survival(value, freedom) }
    }
}
