//! What a report says of the light that was traced.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, Spectrum, TABLE_LEN};

/// Spectrum of all light of the scene, the largest value 1: what counts as white.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct LightReport {
    /// Wavelength of the first value.
    pub first_nm: f32,
    /// Wavelength of the last one.
    pub last_nm: f32,
    /// At every whole nanometre.
    pub relative: Vec<f64>,
}

impl LightReport {
    /// Of that spectrum.
    pub fn new(light: &Spectrum) -> Self {
        // As many digits as a value of the table has.
        let short = |value: &f32| value.to_string().parse().unwrap_or(f64::from(*value));
        Self { first_nm: LAMBDA_MIN_NM, last_nm: LAMBDA_MAX_NM, relative: light.values().iter().map(short).collect() }
    }

    /// The spectrum, if it is all there.
    pub fn spectrum(&self) -> Option<Spectrum> {
        let whole = self.first_nm == LAMBDA_MIN_NM && self.relative.len() == TABLE_LEN;
        let usable = whole && self.relative.iter().all(|value| value.is_finite() && *value >= 0.0);
        usable.then(|| Spectrum::from_fn(|lambda| self.relative[(lambda - f64::from(LAMBDA_MIN_NM)) as usize]))
    }
}

/// How light was traced: the keys of `[render]`, and what came of them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct RenderReport {
    /// Of light transport; that of sensor noise is in the report itself.
    pub seed: u64,
    /// Samples of the pixel that has most.
    pub samples_per_pixel: u32,
    /// Longest path.
    pub max_depth: u32,
    /// Length from which on Russian roulette may end paths.
    pub roulette_depth: u32,
    /// Paths that leave the first surface.
    pub splitting: u32,
    /// Pixels that share paths.
    pub reuse: u32,
    /// Paths from lights for each camera path.
    pub light_paths: f64,
    /// How wavelengths are drawn.
    pub wavelengths: String,
    /// Kind of random numbers.
    pub sampler: String,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Its lights.
    pub lights: usize,
    /// Root-mean-square Monte Carlo noise over root-mean-square sensor noise; `null` in the dark and after a
    /// single sample. The noise is that of independent samples: with Sobol points, its variance is 1.2 to 1.9
    /// times what it is.
    pub noise_ratio: Option<f64>,
    /// `null` without a noise target.
    pub noise: Option<NoiseReport>,
}

/// What became of a noise target.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct NoiseReport {
    /// Monte Carlo noise over sensor noise in each pixel, standard deviations.
    pub target: f64,
    /// Samples of the pixels of the picture.
    pub samples_least: u32,
    /// Mean over the pixels.
    pub samples_mean: f64,
    /// Of the pixel that has most.
    pub samples_most: u32,
    /// Samples a pixel beside those, from which their number was found.
    pub pilot_samples_mean: f64,
    /// Part of the pixels, 0–1, whose measured ratio is at most the target.
    pub pixels_at_target: f64,
    /// The ratio that 99 % of the pixels stay below; `null` where there is not enough light for an exposure.
    pub ratio_of_99_percent: Option<f64>,
}
