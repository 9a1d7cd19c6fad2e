//! Light that paths from lights bring to pixels, until it is added to a film.

use std::ops::Range;

use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

/// Light that paths from lights bring to one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Splat {
    /// Number of the pixel in its film.
    pub(super) pixel: u32,
    /// Number of the sample.
    pub(super) sample: u32,
    /// W·m⁻²·nm⁻¹ at each wavelength.
    pub(super) irradiance: SampledSpectrum,
    pub(super) wavelengths: Wavelengths,
    /// MIS ratio q that it has been weighted by.
    pub(super) mis_ratio: f32,
    /// Whether the first surface of its path casts caustics.
    pub(super) is_caustic: bool,
}

/// Light that paths from lights bring to a film, pixel by pixel and sample by sample.
#[derive(Debug, Default)]
pub(in super::super) struct Splats {
    /// Pixel by pixel and sample by sample.
    pub(super) splats: Vec<Splat>,
}

impl Splat {
    /// Spectral irradiance and its wavelengths.
    pub(in super::super) fn light(&self) -> (SampledSpectrum, &Wavelengths) {
        (self.irradiance, &self.wavelengths)
    }

    /// MIS ratio q that it has been weighted by.
    pub(in super::super) fn mis_ratio(&self) -> f64 {
        f64::from(self.mis_ratio)
    }

    /// Whether the first surface of its path casts caustics.
    pub(in super::super) fn is_caustic(&self) -> bool {
        self.is_caustic
    }

    /// The number of the pixel in its film, and that of the sample.
    pub(in super::super) fn key(&self) -> (u32, u32) {
        (self.pixel, self.sample)
    }
}

impl Splats {
    /// All splats, pixel by pixel and sample by sample.
    pub(in super::super) fn all(&self) -> &[Splat] {
        &self.splats
    }

    /// The splats of one sample of a pixel.
    #[inline]
    pub(in super::super) fn of(&self, pixel: usize, sample: u32) -> &[Splat] {
        let key = (pixel as u32, sample);
        let own = &self.splats[self.splats.partition_point(|splat| splat.key() < key)..];
        &own[..own.iter().take_while(|splat| splat.key() == key).count()]
    }
    /// Splats of some pixels.
    pub(in super::super) fn of_pixels(&self, pixels: Range<usize>) -> &[Splat] {
        let before = |pixel: usize| self.splats.partition_point(|splat| (splat.pixel as usize) < pixel);
        &self.splats[before(pixels.start)..before(pixels.end)]
    }
}
