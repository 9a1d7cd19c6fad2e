//! Input of a render.

use super::{LoadedDevice, RenderSettings};
use crate::film::{Film, FilmResponses, Response};
use crate::optics::Camera;
use crate::scene::Scene;
use photosite_core::spectrum::Spectrum;

/// Input of a render.
pub struct RenderJob<'a> {
    /// Scene in front of the camera.
    pub scene: &'a Scene,
    /// Camera with its lens.
    pub camera: &'a Camera,
    /// Spectral transmittance τ of the lens, 0–1.
    pub transmittance: &'a Spectrum,
    /// Responses of the channels, one for each plane of the film.
    pub responses: &'a [Response],
    /// Filters of the pixels; `None` where all pixels have the same filter.
    pub filters: Option<&'a FilterTile>,
    /// Result of [`importance_for_all`](Self::importance_for_all), where an earlier render has found it.
    pub importance: Option<&'a Spectrum>,
    /// Numbers of columns and rows.
    pub resolution: [u32; 2],
    /// Settings of light transport.
    pub settings: &'a RenderSettings,
    /// Device that traces the paths, loaded with the scene; `None` for the processor.
    pub device: Option<&'a LoadedDevice>,
}

/// Tile of filters that repeats over the pixels of an image.
#[derive(Clone, Debug)]
pub struct FilterTile {
    /// Responses of the sensor behind each kind of filter, any unit, not negative.
    pub responses: Vec<Spectrum>,
    /// Index of a response for each pixel of the tile, row by row.
    pub filters: Vec<usize>,
    /// Number of columns of the tile.
    pub width: usize,
}

impl RenderJob<'_> {
    /// Makes an empty film of the image's size.
    pub fn empty_film(&self, responses: FilmResponses) -> Film {
        let [width, height] = self.resolution.map(|n| n as usize);
        Film::new(width, height, responses)
    }

    /// Whether paths carry one wavelength from the lens on: where the lens spreads points by wavelength, a path that
    /// dispersion left with one wavelength would keep the weights of all four.
    pub(super) fn has_single_wavelengths(&self) -> bool {
        self.camera.spreads_by_wavelength() && self.scene.disperses()
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> u64 {
        self.resolution.iter().map(|&n| u64::from(n)).product()
    }
}
