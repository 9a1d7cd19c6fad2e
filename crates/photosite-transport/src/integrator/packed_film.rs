//! Camera, wavelengths and responses of a render as plain data, for devices that start paths and sum samples
//! themselves.

use crate::film::FilmResponses;
use crate::optics::PackedCamera;
use crate::sampler::PixelOrder;
use photosite_core::spectrum::{Spectrum, WavelengthSampler};

/// Film of a render as plain data; see the module.
#[derive(Clone, Debug)]
pub struct PackedFilm<'a> {
    /// Camera.
    pub camera: &'a PackedCamera,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Squares of pixels in a row of the image that share a sequence of random numbers, binary logarithm of the pixels
    /// along a square, binary logarithm of the samples of a pixel.
    pub order: [u32; 3],
    /// Whether paths carry one wavelength from the lens on.
    pub has_single_wavelengths: bool,
    /// Pieces of the densities of wavelengths, [`PIECES`] each: the probability of all pieces before, the density in
    /// nm⁻¹, and its reciprocal.
    pub densities: Vec<[f32; 3]>,
    /// Number of the density of each pixel of a tile, row by row.
    pub tile: Vec<u32>,
    /// Number of columns of the tile.
    pub tile_width: u32,
    /// Transmittance of the lens at each whole nanometre.
    pub transmittance: Vec<f32>,
    /// Responses at each whole nanometre, of four channels in each of [`Self::groups`] groups.
    pub responses: Vec<[f32; 4]>,
    /// Number of groups of four channels.
    pub groups: u32,
}

/// Number of pieces of a density of wavelengths, with the one where the last ends.
pub const PIECES: usize = photosite_core::spectrum::TABLE_LEN;

impl<'a> PackedFilm<'a> {
    /// Packs the film of an image of `rows` rows, whose wavelengths are drawn by samplers that a tile of pixels names.
    /// `None` where numbers of 32 bits do not tell its random numbers apart.
    pub(super) fn new(
        camera: &'a PackedCamera,
        rows: u32,
        (order, seed): (&PixelOrder, u64),
        ((samplers, tile, tile_width), has_single_wavelengths): ((&[WavelengthSampler], &[usize], usize), bool),
        transmittance: &Spectrum,
        responses: &FilmResponses,
    ) -> Option<Self> {
        Some(Self {
            camera,
            seed,
            order: order.numbers(rows)?,
            has_single_wavelengths,
            densities: samplers.iter().flat_map(|sampler| sampler.pieces()).collect(),
            tile: tile.iter().map(|&density| density as u32).collect(),
            tile_width: tile_width as u32,
            transmittance: transmittance.values().to_vec(),
            responses: responses.table().iter().map(|four| four.to_array()).collect(),
            groups: responses.groups() as u32,
        })
    }
}
