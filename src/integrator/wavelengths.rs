//! Which wavelengths the paths of each pixel carry.
//!
//! One density for all pixels serves all filters: four wavelengths that share it evenly tell nearly as much of red, green
//! and blue as wavelengths of their own would. It does not serve filters that see little of what all see together, as those
//! of multispectral sensors, nor paths that dispersion leaves with one wavelength: most of them carry what the filter above
//! the pixel does not let through. A picture of raw numbers alone needs what the pixel's own filter sees.

use super::RenderJob;
use crate::spectrum::{Spectrum, WavelengthSampler};

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

/// The filters of a picture's pixels: a tile of them, which repeats.
#[derive(Clone, Debug)]
pub struct FilterTile {
    /// What the sensor makes of each wavelength behind each kind of filter, any unit, not negative.
    pub responses: Vec<Spectrum>,
    /// Index of a response for each pixel of the tile, row by row.
    pub filters: Vec<usize>,
    /// Columns of the tile.
    pub width: usize,
}

/// A sampler of wavelengths for each pixel.
pub(super) struct PixelWavelengths {
    samplers: Vec<WavelengthSampler>,
    filters: Vec<usize>,
    width: usize,
}

impl PixelWavelengths {
    /// The part of a pixel's paths that carry what matters to all filters: what the others see of its light stays right on
    /// average, with more noise.
    const FOR_ALL: f64 = 0.02;

    pub(super) fn new(job: &RenderJob<'_>) -> Self {
        // Where a wavelength of the sensor meets no light, a sample would be wasted; where all is dark, any will do.
        let useful = |response: &Spectrum| response.product(job.scene.light_spectrum()).product(job.transmittance);
        let all = useful(job.importance);
        let Some(FilterTile { responses, filters, width }) = job.filters else {
            return Self { samplers: vec![WavelengthSampler::new(&all)], filters: vec![0], width: 1 };
        };
        let mostly = |response: &Spectrum| {
            let own = useful(response);
            let (part, whole) = (own.integral(), all.integral());
            // A filter that lets none of the light through leaves all others.
            let scale = if part > 0.0 { (1.0 - Self::FOR_ALL) / part } else { 0.0 };
            let sum = |lambda, value| scale * value + Self::FOR_ALL / whole * f64::from(all.eval(lambda as f32));
            WavelengthSampler::new(&if whole > 0.0 { own.map(sum) } else { own })
        };
        Self { samplers: responses.iter().map(mostly).collect(), filters: filters.clone(), width: *width }
    }

    /// That of a pixel.
    #[inline]
    pub(super) fn at(&self, column: usize, row: usize) -> &WavelengthSampler {
        let height = self.filters.len() / self.width;
        &self.samplers[self.filters[row % height * self.width + column % self.width]]
    }
}
