//! What a user asks of a render.

use std::ops::Range;
use std::time::Duration;

use crate::sampler::SamplerKind;
use photosite_core::Invalid;

/// How many samples, how long, how deep.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Samples a pixel; where a time limit or a noise target is given too, at most so many.
    pub samples_per_pixel: u32,
    /// Those of them to be traced, the others belonging to other parts of the same render; `None` for all.
    pub part: Option<Range<u32>>,
    /// Stop after this long, at the end of a pass.
    pub time_limit: Option<Duration>,
    /// Stop in each pixel once Monte Carlo noise is below this part of the sensor's noise (ratio of standard
    /// deviations). [`render`](super::render()) leaves it to [`pilot`](super::pilot).
    pub noise_target: Option<f64>,
    /// Largest number of path segments from the camera; 1 sees emitters only, 2 direct light.
    pub max_depth: u32,
    /// Number of segments after which Russian roulette may end a path.
    pub roulette_depth: u32,
    /// Number of paths that go on from the first surface that is no mirror, for each sample of the picture.
    pub splitting: u32,
    /// Number of neighbouring pixels that share what their paths find beyond the first surface, at least 1. Without
    /// effect where the camera moves.
    pub reuse: u32,
    /// Number of paths from lights, for the sake of caustics, for each sample of the picture; 0 for none. Without
    /// effect where the camera moves or scans.
    pub light_paths: f64,
    /// Whose wavelengths the paths of a pixel carry, where pixels have [filters](super::RenderJob::filters) of their
    /// own.
    pub wavelengths: WavelengthChoice,
    /// Where random numbers come from.
    pub sampler: SamplerKind,
    /// Seed of light transport and sensor noise.
    pub seed: u64,
}

/// Whose wavelengths the paths of a pixel carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WavelengthChoice {
    /// Those that matter to any filter.
    AllFilters,
    /// Mostly those that matter to the filter of the pixel.
    OwnFilter,
}

impl WavelengthChoice {
    /// The name that capture files use.
    pub fn name(self) -> &'static str {
        match self {
            Self::AllFilters => "all-filters",
            Self::OwnFilter => "own-filter",
        }
    }
}

/// More than so many paths from one surface are better spent on other samples.
const MOST_SPLITTING: u32 = 256;

/// Connections grow with the square.
const MOST_REUSE: u32 = 64;

/// More than so many paths from lights are better spent on other samples.
const MOST_LIGHT_PATHS: f64 = 64.0;

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            samples_per_pixel: 64,
            part: None,
            time_limit: None,
            noise_target: None,
            max_depth: 16,
            roulette_depth: 5,
            splitting: 1,
            reuse: 1,
            light_paths: 0.0,
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

    /// Columns and rows of the groups of pixels that share: as near to a square as their number allows, rather wide
    /// than high. A film of a part of the picture begins with a whole group.
    pub fn reuse_columns_and_rows(&self) -> [usize; 2] {
        let pixels = self.reuse.max(1);
        let rows = (1..=pixels.isqrt()).rev().find(|&rows| pixels.is_multiple_of(rows)).unwrap_or(1);
        [pixels / rows, rows].map(|n| n as usize)
    }

    /// Refuses what cannot be rendered. Keys are those of the capture file's `[render]` table.
    pub fn validate(&self) -> Result<(), Invalid> {
        if self.samples_per_pixel == 0 {
            return Err(Invalid::new("samples_per_pixel", "must be at least 1, got 0")
                .help("for example samples_per_pixel = 64"));
        }
        if self.max_depth == 0 {
            return Err(Invalid::new("max_depth", "must be at least 1, got 0").help("for example max_depth = 16"));
        }
        if !(1..=MOST_SPLITTING).contains(&self.splitting) {
            let message = format!("must be from 1 to {MOST_SPLITTING}, got {}", self.splitting);
            return Err(Invalid::new("splitting", message).help("for example splitting = 4"));
        }
        if !(1..=MOST_REUSE).contains(&self.reuse) {
            let message = format!("must be from 1 to {MOST_REUSE}, got {}", self.reuse);
            return Err(Invalid::new("reuse", message).help("for example reuse = 16"));
        }
        if self.reuse > 1 && self.wavelengths == WavelengthChoice::OwnFilter {
            let message =
                "cannot be combined with wavelengths = \"own-filter\": what pixels share has the same wavelengths";
            return Err(Invalid::new("reuse", message).help("remove one of the two"));
        }
        if self.light_paths > 0.0 && self.wavelengths == WavelengthChoice::OwnFilter {
            let message = "cannot be combined with wavelengths = \"own-filter\": light comes to pixels of all filters";
            return Err(Invalid::new("light_paths", message).help("remove one of the two"));
        }
        if self.reuse > 1 && self.light_paths > 0.0 {
            let message =
                "cannot be combined with light_paths: what paths from lights find counts by the pixel that sees it";
            return Err(Invalid::new("reuse", message).help("remove one of the two"));
        }
        if !(0.0..=MOST_LIGHT_PATHS).contains(&self.light_paths) {
            let message = format!("must be from 0 to {MOST_LIGHT_PATHS}, got {}", self.light_paths);
            return Err(Invalid::new("light_paths", message).help("for example light_paths = 0.5"));
        }
        if let Some(target) = self.noise_target
            && !(target.is_finite() && target > 0.0)
        {
            return Err(Invalid::new("noise_target", format!("must be above 0, got {target}"))
                .help("for example noise_target = 0.2"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_that_share_are_as_near_to_a_square_as_their_number_allows() {
        for (reuse, columns_and_rows) in
            [(1, [1, 1]), (2, [2, 1]), (7, [7, 1]), (12, [4, 3]), (16, [4, 4]), (32, [8, 4]), (64, [8, 8])]
        {
            let settings = RenderSettings { reuse, ..RenderSettings::default() };
            assert_eq!(settings.reuse_columns_and_rows(), columns_and_rows, "{reuse}");
        }
    }
}
