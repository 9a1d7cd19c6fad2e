//! Materials as light transport reads them: handles instead of descriptions.

use crate::bsdf::Ggx;
use crate::light::SurfaceEmission;
use crate::spectrum::SpectrumId;

/// A material of a [`Scene`](super::Scene).
#[derive(Clone, Debug)]
pub struct Material {
    /// How it scatters.
    pub model: ScatteringModel,
    /// Bumps.
    pub normal_map: Option<NormalMap>,
    /// Its own light.
    pub emission: Option<SurfaceEmission>,
    /// Its holes.
    pub alpha: Alpha,
}

/// A reflectance that may vary over a surface.
#[derive(Clone, Copy, Debug)]
pub enum ColourSource {
    /// The same everywhere.
    Spectrum(SpectrumId),
    /// A linear sRGB factor times a texture, upsampled point by point.
    Texture {
        /// Linear sRGB.
        factor: [f32; 3],
        /// Handle of an sRGB-encoded texture.
        texture: u32,
    },
    /// A spectrum times an upsampled texture.
    SpectrumTexture {
        /// Handle of the spectrum.
        spectrum: SpectrumId,
        /// Handle of an sRGB-encoded texture.
        texture: u32,
    },
}

/// Scattering models with what they need at a shading point.
#[derive(Clone, Copy, Debug)]
pub enum ScatteringModel {
    /// Lambert's law.
    Diffuse {
        /// Reflectance.
        reflectance: ColourSource,
    },
    /// A metal.
    Conductor {
        /// Real part of the index.
        eta: SpectrumId,
        /// Imaginary part of the index.
        k: SpectrumId,
        /// Microfacets.
        distribution: Ggx,
    },
    /// Clear glass.
    Dielectric {
        /// Relative index, inside over outside.
        eta: SpectrumId,
        /// Whether the index depends on wavelength.
        dispersive: bool,
        /// Microfacets.
        distribution: Ggx,
    },
    /// glTF metallic-roughness.
    MetallicRoughness {
        /// Base colour.
        base_colour: ColourSource,
        /// Metalness factor.
        metallic: f32,
        /// Perceptual roughness factor.
        roughness: f32,
        /// Handle of a linear texture: G roughness, B metalness.
        texture: Option<u32>,
    },
}

/// A tangent-space normal map.
#[derive(Clone, Copy, Debug)]
pub struct NormalMap {
    /// Handle of a linear texture.
    pub texture: u32,
    /// Factor of x and y.
    pub scale: f32,
}

/// Where a surface is.
#[derive(Clone, Copy, Debug)]
pub enum Alpha {
    /// Everywhere.
    Opaque,
    /// Where alpha ≥ cutoff.
    Mask {
        /// Alpha factor.
        factor: f32,
        /// Texture whose alpha multiplies it.
        texture: Option<u32>,
        /// Threshold.
        cutoff: f32,
    },
    /// With probability alpha.
    Blend {
        /// Alpha factor.
        factor: f32,
        /// Texture whose alpha multiplies it.
        texture: Option<u32>,
    },
}
