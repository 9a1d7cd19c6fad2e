//! What a render reads.

use super::RenderSettings;
use crate::film::{Film, FilmResponses, Response};
use crate::optics::Camera;
use crate::scene::Scene;
use photosite_core::spectrum::Spectrum;

/// Everything that a render reads.
pub struct RenderJob<'a> {
    /// What is in front of the camera.
    pub scene: &'a Scene,
    /// The lens.
    pub camera: &'a Camera,
    /// The lens's spectral transmittance τ.
    pub transmittance: &'a Spectrum,
    /// What is made of each wavelength: what the planes of the film hold.
    pub responses: &'a [Response],
    /// The filters of the pixels; `None` where all pixels have the same.
    pub filters: Option<&'a FilterTile>,
    /// What [`importance_for_all`](Self::importance_for_all) gives, where an earlier render has found it.
    pub importance: Option<&'a Spectrum>,
    /// Columns and rows.
    pub resolution: [u32; 2],
    /// Depth, seed, sampler, limits.
    pub settings: &'a RenderSettings,
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

impl RenderJob<'_> {
    /// A film of the picture's size.
    pub fn empty_film(&self, responses: FilmResponses) -> Film {
        let [width, height] = self.resolution.map(|n| n as usize);
        Film::new(width, height, responses)
    }

    /// Whether paths carry one wavelength from the lens on: where it spreads points by wavelength, what dispersion
    /// takes from a path later would leave the weights of all four to the one that is left.
    pub(super) fn has_single_wavelengths(&self) -> bool {
        self.camera.spreads_by_wavelength() && self.scene.disperses()
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> u64 {
        self.resolution.iter().map(|&n| u64::from(n)).product()
    }
}
