//! Light that a surface gives by itself.

use photosite_core::spectrum::upsampling::unbounded_polynomial;
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, SpectrumTable, Wavelengths};

/// Emitted radiance of a surface, W·m⁻²·sr⁻¹·nm⁻¹, the same in all directions.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceEmission {
    /// Radiance where the tint is white.
    pub radiance: SpectrumId,
    /// Colour that may vary over the surface.
    pub tint: Tint,
    /// Whether the back shines too.
    pub two_sided: bool,
}

/// A colour that multiplies an emission spectrum.
#[derive(Clone, Copy, Debug)]
pub enum Tint {
    /// White tint.
    None,
    /// Linear sRGB factor times a texture.
    Textured {
        /// Linear sRGB.
        factor: [f32; 3],
        /// Handle of the texture.
        texture: u32,
    },
}

/// The spectrum of a linear sRGB tint of any brightness, by which white light is multiplied.
#[inline]
pub(super) fn tint_spectrum(rgb: [f32; 3], wavelengths: &Wavelengths) -> SampledSpectrum {
    let (factor, polynomial) = unbounded_polynomial(rgb);
    polynomial.sample(wavelengths) * factor
}

impl SurfaceEmission {
    /// Radiance at the given tint (linear sRGB, looked up by the caller).
    #[inline]
    pub fn radiance(
        &self,
        spectra: &SpectrumTable,
        tint: Option<[f32; 3]>,
        wavelengths: &Wavelengths,
    ) -> SampledSpectrum {
        let radiance = spectra.sample(self.radiance, wavelengths);
        tint.map_or(radiance, |rgb| radiance * tint_spectrum(rgb, wavelengths))
    }

    /// The tint of a texel: the factor times it.
    #[inline]
    pub fn tinted(&self, texel: [f32; 3]) -> [f32; 3] {
        match self.tint {
            Tint::None => [1.0; 3],
            Tint::Textured { factor, .. } => [0, 1, 2].map(|i| factor[i] * texel[i]),
        }
    }
}
