//! Materials as light transport reads them: handles instead of descriptions.

use crate::bsdf::Ggx;
use crate::light::SurfaceEmission;
use photosite_core::spectrum::SpectrumId;

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
    /// Absorption of the closed volume that it bounds, m⁻¹.
    pub absorption: Option<SpectrumId>,
}

impl Material {
    /// The reflectance of what scatters by Lambert's law, without bumps or light of its own, and is nothing else.
    pub(super) fn reflectance_alone(&self) -> Option<ColourSource> {
        let ScatteringModel::Diffuse { reflectance } = self.model else { return None };
        (self.normal_map.is_none() && self.emission.is_none()).then_some(reflectance)
    }
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
    /// A matt surface with relief.
    OrenNayar {
        /// Reflectance.
        reflectance: ColourSource,
        /// 0–1.
        roughness: f32,
    },
    /// Phong's model.
    Phong {
        /// The part scattered by Lambert's law.
        diffuse: ColourSource,
        /// The part in the lobe.
        specular: ColourSource,
        /// Exponent of the lobe.
        exponent: f32,
    },
    /// A thin matt sheet.
    Translucent {
        /// Reflectance.
        reflectance: ColourSource,
        /// Transmittance.
        transmittance: ColourSource,
    },
    /// A polished pane.
    ThinDielectric {
        /// Relative index.
        eta: SpectrumId,
        /// Internal transmittance along the normal.
        transmittance: SpectrumId,
    },
    /// Two models side by side: handle among the mixes.
    Mix(u32),
    /// glTF's material: handle among the layered materials.
    Layered(u32),
}

/// Two models side by side.
#[derive(Clone, Copy, Debug)]
pub struct Mix {
    /// Both.
    pub models: [ScatteringModel; 2],
    /// The part of the second, 0–1.
    pub weight: f32,
}

/// A number, times a channel of a linear texture.
#[derive(Clone, Copy, Debug)]
pub struct FactorSource {
    /// The number.
    pub value: f32,
    /// Handle of the texture, and which channel of it counts.
    pub texture: Option<(u32, usize)>,
}

/// A [`LayeredDescription`](super::description::LayeredDescription) with handles.
#[derive(Clone, Debug)]
pub struct LayeredMaterial {
    /// Reflectance of the coloured base, F₀ of the metal, tint of transmission.
    pub base_colour: ColourSource,
    /// Metalness.
    pub metallic: FactorSource,
    /// Perceptual roughness.
    pub roughness: FactorSource,
    /// Index, and whether it depends on wavelength.
    pub eta: SpectrumId,
    /// Whether it does.
    pub dispersive: bool,
    /// Reflectance at normal incidence that the index gives.
    pub f0: f32,
    /// Weight of the facets' reflection.
    pub specular: FactorSource,
    /// Linear sRGB factor of F₀ and the texture that scales it; none for white.
    pub specular_colour: Option<ColourSource>,
    /// Factor of F₀ that is no colour, for colours above 1.
    pub specular_scale: f32,
    /// What goes on.
    pub transmission: FactorSource,
    /// Whether the surface bounds a volume.
    pub has_volume: bool,
    /// What comes out behind, and its colour.
    pub diffuse_transmission: Option<(FactorSource, ColourSource)>,
    /// Grooves.
    pub anisotropy: Option<AnisotropySource>,
    /// A thin film.
    pub film: Option<FilmSource>,
    /// Fibres: colour and roughness.
    pub sheen: Option<(ColourSource, FactorSource)>,
    /// Varnish.
    pub coat: Option<CoatSource>,
}

impl LayeredMaterial {
    /// Whether it may throw light on in bundles at some of its points.
    pub(super) fn may_focus(&self) -> bool {
        // Textures only make it smoother.
        let may_be_narrow = |roughness: FactorSource| {
            let alpha = roughness.value * roughness.value;
            roughness.texture.is_some() || Ggx::new(alpha, alpha).is_narrow()
        };
        may_be_narrow(self.roughness)
            || self.coat.is_some_and(|coat| may_be_narrow(coat.roughness))
            || self.has_volume && self.transmission.value > 0.0
    }
}

/// Grooves.
#[derive(Clone, Copy, Debug)]
pub struct AnisotropySource {
    /// 0–1.
    pub strength: f32,
    /// Cosine and sine of the rotation of the rougher direction from the tangent.
    pub rotation: [f32; 2],
    /// Handle of a linear texture: R, G direction, B strength.
    pub texture: Option<u32>,
}

/// A thin film.
#[derive(Clone, Copy, Debug)]
pub struct FilmSource {
    /// 0–1.
    pub weight: FactorSource,
    /// Refractive index.
    pub index: f32,
    /// From where the texture is 0 to where it is 1, nm.
    pub thickness_nm: [f32; 2],
    /// Handle of a linear texture whose green says where between; none for the second.
    pub texture: Option<u32>,
}

/// Varnish.
#[derive(Clone, Copy, Debug)]
pub struct CoatSource {
    /// 0–1.
    pub weight: FactorSource,
    /// Perceptual roughness.
    pub roughness: FactorSource,
    /// Its own bumps.
    pub normal_map: Option<NormalMap>,
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
