//! Estimate of the noise of a patch.

use serde::Serialize;

use super::autocovariance::Autocovariance;
use super::neighbourhoods::Neighbourhoods;
use super::patch::Variance;
use super::plane_fit::PlaneFit;
use super::signal_to_noise::SignalToNoise;
use super::temporal::TemporalNoise;

/// Estimate of the noise of a patch. σ are standard deviations; "error" is the standard error of the figure before it,
/// for normally distributed noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NoiseEstimate {
    /// Images that were looked at.
    pub pictures: usize,
    /// Columns and rows of the patch.
    pub size: [usize; 2],
    /// Mean value μ.
    pub mean: f64,
    /// Temporal noise, from several images of the same light; `None` for a single one.
    pub temporal: Option<TemporalNoise>,
    /// Sample variance Σ(y − μ)²/(n − 1) of one patch, taken to be even; that of the average where there are several
    /// images.
    pub uniform: Variance,
    /// Plane fitted to one patch, whose shading is taken to be linear, and the noise that it leaves.
    pub plane: PlaneFit,
    /// Noise from many small squares, each with a plane of its own; `None` where the patch is smaller than one.
    pub neighbourhoods: Option<Neighbourhoods>,
    /// Autocovariance of the noise of neighbouring pixels: of the changes from image to image, or of the residuals of a
    /// plane.
    pub autocovariance: Autocovariance,
    /// Signal over noise.
    pub snr: SignalToNoise,
    /// Rounding's part.
    pub quantisation: Option<Quantisation>,
}

/// Quantisation noise of rounding to steps of q.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantisation {
    /// q.
    pub step: f64,
    /// Variance of rounding, q²/12, if the noise is no smaller than about half a step.
    pub variance: f64,
    /// Part of the variance found that is quantisation noise, percent.
    pub part_percent: Option<f64>,
}
