//! Report of the light that was traced.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::math::float::rounded;
use photosite_core::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, Spectrum, TABLE_LEN};
use photosite_transport::integrator::{LightPathKind, Plan, WavelengthChoice};
use photosite_transport::sampler::SamplerKind;

/// Spectrum of all light of the scene, the largest value 1: what counts as white.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct LightReport {
    /// Wavelength of the first value, nm.
    pub first_nm: f32,
    /// Wavelength of the last value, nm.
    pub last_nm: f32,
    /// Values at every whole nanometre.
    pub relative: Vec<f64>,
}

impl LightReport {
    /// Report of a spectrum.
    pub fn new(light: &Spectrum) -> Self {
        // As many digits as a value of the table has.
        let short = |value: &f32| value.to_string().parse().unwrap_or(f64::from(*value));
        Self { first_nm: LAMBDA_MIN_NM, last_nm: LAMBDA_MAX_NM, relative: light.values().iter().map(short).collect() }
    }

    /// Spectrum of the light, if it is complete.
    pub fn spectrum(&self) -> Option<Spectrum> {
        let whole = self.first_nm == LAMBDA_MIN_NM && self.relative.len() == TABLE_LEN;
        let usable = whole && self.relative.iter().all(|value| value.is_finite() && *value >= 0.0);
        usable.then(|| Spectrum::from_fn(|lambda| self.relative[(lambda - f64::from(LAMBDA_MIN_NM)) as usize]))
    }
}

/// Settings of tracing, which are the keys of `[render]`, and its results.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct RenderReport {
    /// Seed of light transport; that of sensor noise is in the report itself.
    pub seed: u64,
    /// Samples of the pixel that has most.
    pub samples_per_pixel: u32,
    /// Maximum depth of a path, segments.
    pub max_depth: u32,
    /// Depth from which on Russian roulette may end paths.
    pub roulette_depth: u32,
    /// Path splitting: number of paths that continue from the first non-specular vertex.
    pub splitting: u32,
    /// Number of paths from lights for each camera path.
    pub light_paths: f64,
    /// Plan that chose splitting and light paths where the capture left them open; `null` where nothing was chosen. Where
    /// a camera or a scene moves, each image has its own, and this is the last one's.
    #[serde(default)]
    pub plan: Option<PlanReport>,
    /// Method of drawing wavelengths.
    pub wavelengths: WavelengthChoice,
    /// Kind of random numbers.
    pub sampler: SamplerKind,
    /// Device that traced the light, with its interface and driver; left out for the processor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Number of lights of the scene.
    pub lights: usize,
    /// Root-mean-square Monte Carlo noise over root-mean-square sensor noise; `null` in the dark, after a single sample
    /// and where all pixels are saturated. The noise is that of independent samples: with Sobol points, its variance
    /// is 1.2 to 1.9 times what it is.
    pub noise_ratio: Option<f64>,
    /// Part of the pixels, 0–1, that are saturated, where no noise shows: the noise ratio is that of the others. Left
    /// out where none is, and where the ratio is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturated_part: Option<f64>,
    /// Result of the noise target; `null` without one.
    pub noise: Option<NoiseReport>,
}

/// Plan of light transport, found by pilot samples.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct PlanReport {
    /// Path splitting: number of paths that continue from the first non-specular vertex.
    pub splitting: u32,
    /// Number of paths from lights for each camera path.
    pub light_paths: f64,
    /// Light that they bring; left out where there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light_path_kind: Option<LightPathKind>,
    /// Expected efficiency, 1/(variance · cost), as a multiple of that of plain paths.
    pub gain: f64,
    /// Cost of the pilots, as a part of that of the whole render.
    pub cost: f64,
}

impl PlanReport {
    /// Words on what was chosen, and on what it is expected to bring.
    pub fn words(&self) -> String {
        let Self { splitting, light_paths, light_path_kind, gain, cost } = *self;
        let found = format!("found by samples of {} % of the cost", rounded(100.0 * cost, 2));
        let branches = if splitting == 1 { "1 branch".to_owned() } else { format!("{splitting} branches") };
        let for_light = match light_path_kind {
            None => "",
            Some(LightPathKind::Caustics) => " for caustics",
            Some(LightPathKind::Indirect) => " for indirect light",
        };
        let paths = format!("{branches} a path, light paths {light_paths}{for_light}");
        match gain {
            ..=1.0 if splitting == 1 && light_paths == 0.0 => {
                format!("strategy: neither more branches nor light paths would pay, {found}")
            }
            // Paths that split or set out from lights without a gain are those that the capture sets.
            ..=1.0 => format!("strategy: {paths}: no other numbers would pay, {found}"),
            _ => {
                let times = rounded(gain, 2);
                format!("strategy: {paths}: expected {times} times as efficient as plain paths, {found}")
            }
        }
    }
}

impl From<Plan> for PlanReport {
    fn from(plan: Plan) -> Self {
        let Plan { splitting, light_paths, light_path_kind, gain, cost } = plan;
        let light_path_kind = (light_paths > 0.0).then_some(light_path_kind);
        Self { splitting, light_paths, light_path_kind, gain: rounded(gain, 3), cost: rounded(cost, 2) }
    }
}

/// Result of a noise target.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct NoiseReport {
    /// Monte Carlo noise over sensor noise in each pixel, standard deviations.
    pub target: f64,
    /// Samples of the pixel that has fewest.
    pub samples_least: u32,
    /// Mean samples of the pixels.
    pub samples_mean: f64,
    /// Samples of the pixel that has most.
    pub samples_most: u32,
    /// Samples per pixel beside those, from which their number was found.
    pub pilot_samples_mean: f64,
    /// Part of the pixels, 0–1, whose measured ratio is at most the target.
    pub pixels_at_target: f64,
    /// Noise ratio that 99 % of the pixels stay below; `null` where there is not enough light for an exposure.
    pub ratio_of_99_percent: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_on_a_plan_are_of_the_numbers_that_are_used() {
        let words = |splitting, light_paths, gain| {
            let light_path_kind = (light_paths > 0.0).then_some(LightPathKind::Caustics);
            PlanReport { splitting, light_paths, light_path_kind, gain, cost: 0.03 }.words()
        };
        let found = "found by samples of 3 % of the cost";
        assert_eq!(words(1, 0.0, 1.0), format!("strategy: neither more branches nor light paths would pay, {found}"));
        for (splitting, light_paths, paths) in [
            (1, 0.5, "1 branch a path, light paths 0.5 for caustics"),
            (4, 0.0, "4 branches a path, light paths 0"),
            (4, 1.0, "4 branches a path, light paths 1 for caustics"),
        ] {
            let set = words(splitting, light_paths, 1.0);
            assert_eq!(set, format!("strategy: {paths}: no other numbers would pay, {found}"));
            let chosen = words(splitting, light_paths, 2.0);
            assert_eq!(chosen, format!("strategy: {paths}: expected 2 times as efficient as plain paths, {found}"));
        }
    }
}
