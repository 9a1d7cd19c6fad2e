//! What is found of the noise of a patch.

use serde::Serialize;

use super::autocovariance::Autocovariance;
use super::neighbourhoods::Neighbourhoods;
use super::patch::Variance;
use super::plane_fit::PlaneFit;
use super::signal_to_noise::SignalToNoise;
use super::temporal::TemporalNoise;

/// What a patch tells of its noise. σ are standard deviations; "error" is the standard error of the figure before it,
/// for normally distributed noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NoiseEstimate {
    /// Pictures that were looked at.
    pub pictures: usize,
    /// Columns and rows of the patch.
    pub size: [usize; 2],
    /// Mean value μ.
    pub mean: f64,
    /// From several pictures: what changes from one to the next.
    pub temporal: Option<TemporalNoise>,
    /// From one patch taken to be even: its sample variance Σ(y − μ)²/(n − 1). Of several pictures it is that of their
    /// average.
    pub uniform: Variance,
    /// From one patch whose shading is linear: a plane and what is left of it.
    pub plane: PlaneFit,
    /// From many small squares, each with a plane of its own; `None` where the patch is smaller than one.
    pub neighbourhoods: Option<Neighbourhoods>,
    /// How noise of neighbouring pixels goes together: of what changes from picture to picture, or of what a plane
    /// leaves.
    pub autocovariance: Autocovariance,
    /// Signal over noise.
    pub snr: SignalToNoise,
    /// Rounding's part.
    pub quantisation: Option<Quantisation>,
}

/// What rounding to steps of q adds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantisation {
    /// q.
    pub step: f64,
    /// Its variance q²/12, if the noise is no smaller than about half a step.
    pub variance: f64,
    /// Its part of the variance found, percent.
    pub part_percent: Option<f64>,
}
