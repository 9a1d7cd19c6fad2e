//! Settings that a user makes for a render.

use std::ops::Range;
use std::time::Duration;

use crate::sampler::SamplerKind;
use crate::scene::Scene;
use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::schema_range::{above, within};

/// Settings of light transport.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSettings {
    /// Samples per pixel; their largest number with a time limit or a noise target. Left out: 64.
    #[schemars(transform = within(1.0..))]
    #[keys(example = "64")]
    pub samples_per_pixel: u32,
    /// Range of the samples to be traced, where others belong to other parts of the same render; `None` for all.
    #[serde(skip)]
    pub part: Option<Range<u32>>,
    /// Time limit of rendering, s. Left out: no limit.
    #[schemars(transform = above(0.0..))]
    pub time_limit_s: Option<f64>,
    /// Noise target: rendering stops in each pixel once its Monte Carlo noise is below this part of the sensor's noise
    /// at that pixel and exposure (ratio of standard deviations).
    #[schemars(transform = above(0.0..))]
    #[keys(example = "0.2")]
    pub noise_target: Option<f64>,
    /// Largest number of segments of a light path; 1 sees emitters only, 2 direct light. Left out: 16.
    #[schemars(transform = within(1.0..))]
    #[keys(example = "16")]
    pub max_depth: u32,
    /// Number of segments after which Russian roulette may end a path (without bias). Left out: 5.
    pub roulette_depth: u32,
    /// Strategy of light transport: "auto" measures with a few samples that are no part of the image how many paths
    /// split off, how many set out from lights, and for which light, to bring most for their time, in renders of more than a
    /// million samples; "plain" lets one path from the camera go on. What splitting and light_paths say stays as it is said.
    /// Left out: "auto".
    pub strategy: StrategyChoice,
    /// Path splitting: the number of paths that continue from the first non-specular surface of each sample, 1 to 256.
    /// More of them lessen the noise of indirect light for less time than more samples. Left out: what strategy chooses.
    #[schemars(transform = within(1.0..=f64::from(MOST_SPLITTING)))]
    #[keys(example = "4")]
    pub splitting: Option<u32>,
    /// Light paths: the number of paths per sample that start on emitting surfaces, 0 to 64. They find caustics, the
    /// light that glass, mirrors and polished metal focus on other surfaces; in scenes without these, and where strategy
    /// chooses so, all light that comes by way of other surfaces, as from a lamp behind a screen. They are refused where a
    /// camera or a scene moves, on sensors that scan, and with wavelengths = "own-filter". Left out: what strategy
    /// chooses.
    #[schemars(transform = within(0.0..=MOST_LIGHT_PATHS))]
    #[keys(example = "0.5")]
    pub light_paths: Option<f64>,
    /// Kind of light that light paths bring; `None` for the first of [`LightPathKind::of`] the scene.
    #[serde(skip)]
    pub light_path_kind: Option<LightPathKind>,
    /// Wavelength sampling: "all-filters" draws the wavelengths of a path by the sensitivity of all channels;
    /// "own-filter" mostly by that of the filter above the pixel, for raw images of glass that disperses or through
    /// more than four narrow filters. Then the other channels of electrons.exr, irradiance.exr and ideal.exr are
    /// noisier, and in other scenes the raw image is noisier, too. It has no effect where all pixels have the same
    /// filter. Left out: "all-filters".
    pub wavelengths: WavelengthChoice,
    /// Sampler of random numbers. Left out: "sobol".
    pub sampler: SamplerKind,
    /// Seed of rendering and sensor noise. Left out: 0.
    pub seed: u64,
}

/// Strategy of light transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum StrategyChoice {
    /// Numbers of paths that a pilot has found to bring most for their time.
    Auto,
    /// One path from the camera for each sample.
    Plain,
}

/// Kind of light that light paths bring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightPathKind {
    /// Light that glass, mirrors and polished metal focus on other surfaces.
    Caustics,
    /// All light that comes to a surface by way of another.
    Indirect,
}

impl LightPathKind {
    /// Kinds that there are to choose from in a scene, the one for renders without a plan first: caustics where there may
    /// be any, since light paths find them far better than camera paths do, and other indirect light seldom.
    pub fn of(scene: &Scene) -> &'static [Self] {
        if scene.may_cast_caustics() { &[Self::Caustics, Self::Indirect] } else { &[Self::Indirect] }
    }

    /// Whether light paths bring what a surface sends that casts caustics or not, and is not the first.
    #[inline]
    pub(super) fn holds(self, casts_caustics: bool) -> bool {
        casts_caustics || self == Self::Indirect
    }
}

/// Wavelength sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum WavelengthChoice {
    /// Wavelengths drawn by the sensitivity of all channels of the sensor.
    AllFilters,
    /// Wavelengths drawn mostly by the sensitivity of the pixel's own filter.
    OwnFilter,
}

/// Largest number of paths from one surface; more are better spent on other samples.
const MOST_SPLITTING: u32 = 256;

/// Largest number of paths from lights per sample; more are better spent on other samples.
const MOST_LIGHT_PATHS: f64 = 64.0;

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            samples_per_pixel: 64,
            part: None,
            time_limit_s: None,
            noise_target: None,
            max_depth: 16,
            roulette_depth: 5,
            strategy: StrategyChoice::Auto,
            splitting: None,
            light_paths: None,
            light_path_kind: None,
            wavelengths: WavelengthChoice::AllFilters,
            sampler: SamplerKind::Sobol,
            seed: 0,
        }
    }
}

impl RenderSettings {
    /// The samples of every pixel that are to be traced.
    pub fn samples(&self) -> Range<u32> {
        self.part.clone().unwrap_or(0..self.samples_per_pixel)
    }

    /// Number of paths that continue from the first non-specular surface, one unless it is set.
    pub fn splitting(&self) -> u32 {
        self.splitting.unwrap_or(1)
    }

    /// Number of light paths per sample, none unless it is set.
    pub fn light_paths(&self) -> f64 {
        self.light_paths.unwrap_or(0.0)
    }

    /// The time after which a render stops, at the end of a pass.
    pub fn time_limit(&self) -> Option<Duration> {
        self.time_limit_s.and_then(|s| Duration::try_from_secs_f64(s).ok())
    }

    /// Refuses what cannot be rendered. Keys are those of the capture file's `[render]` table.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.check_ranges()?;
        if let Some(time) = self.time_limit_s
            && self.time_limit().is_none_or(|limit| limit.is_zero())
        {
            return Err(Invalid::new("time_limit_s", format!("must be above 0, got {time}"))
                .help("for example time_limit_s = 30"));
        }
        if self.light_paths() > 0.0 && self.wavelengths == WavelengthChoice::OwnFilter {
            let message = "cannot be combined with wavelengths = \"own-filter\": light comes to pixels of all filters";
            return Err(Invalid::new("light_paths", message).help("remove one of the two"));
        }
        Ok(())
    }
}
