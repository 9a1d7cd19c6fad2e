//! Materials as light transport reads them: handles instead of descriptions.

use crate::bsdf::{Diffuse, Form, Ggx, Model, RelativeIndex, SceneTraits, TableForm};
use crate::light::SurfaceEmission;
use photosite_core::spectrum::SpectrumId;

/// A material of a [`Scene`](super::Scene).
#[derive(Clone, Debug)]
pub struct Material {
    /// Scattering model of the surface.
    pub model: ScatteringModel,
    /// Normal map of the surface.
    pub normal_map: Option<NormalMap>,
    /// Light that the surface emits.
    pub emission: Option<SurfaceEmission>,
    /// Alpha of the surface, which makes holes.
    pub alpha: Alpha,
    /// Absorption of the closed volume that the surface bounds, m⁻¹.
    pub absorption: Option<SpectrumId>,
}

impl Material {
    /// The reflectance of what scatters by Lambert's law, without bumps or light of its own, and is nothing else.
    pub(super) fn only_reflectance(&self) -> Option<ColourSource> {
        let Model::Diffuse(Diffuse { reflectance }) = self.model else { return None };
        (self.normal_map.is_none() && self.emission.is_none()).then_some(reflectance)
    }
}

/// A reflectance that may vary over a surface.
#[derive(Clone, Copy, Debug)]
pub enum ColourSource {
    /// Spectrum that is the same everywhere.
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

/// A scattering model with handles.
pub type ScatteringModel = Model<Tabled>;

/// Parameters as handles into the tables of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Tabled;

impl Form for Tabled {
    type Colour = ColourSource;
    type Spectrum = SpectrumId;
    type Index = RelativeIndex<SpectrumId>;
    type Distribution = Ggx;
    /// Handle among the layered materials.
    type Layered = u32;
    /// Handle among the mixes.
    type Mix = u32;
}

impl TableForm for Tabled {}

/// A number, times a channel of a linear texture.
#[derive(Clone, Copy, Debug)]
pub struct FactorSource {
    /// Number that multiplies the texture.
    pub value: f32,
    /// Handle of the texture, and the index of the channel of it that counts.
    pub texture: Option<(u32, usize)>,
}

/// A [`LayeredDescription`](super::description::LayeredDescription) with handles.
#[derive(Clone, Debug)]
pub struct LayeredMaterial {
    /// Reflectance of the coloured base, F₀ of the metal, tint of transmission.
    pub base_colour: ColourSource,
    /// Metalness, 0–1.
    pub metallic: FactorSource,
    /// Perceptual roughness, 0–1.
    pub roughness: FactorSource,
    /// Refractive index by wavelength.
    pub eta: SpectrumId,
    /// Whether the index depends on wavelength.
    pub dispersive: bool,
    /// Reflectance at normal incidence that the index gives.
    pub f0: f32,
    /// Weight of the facets' reflection.
    pub specular: FactorSource,
    /// Linear sRGB factor of F₀ and the texture that scales it; none for white.
    pub specular_colour: Option<ColourSource>,
    /// Factor of F₀ that is no colour, for colours above 1.
    pub specular_scale: f32,
    /// Part of the light let in that goes straight on or is refracted, 0–1.
    pub transmission: FactorSource,
    /// Whether the surface bounds a volume.
    pub has_volume: bool,
    /// Part of the other light let in that comes out behind, 0–1, and its colour.
    pub diffuse_transmission: Option<(FactorSource, ColourSource)>,
    /// Grooves, which make roughness anisotropic.
    pub anisotropy: Option<AnisotropySource>,
    /// A thin film.
    pub film: Option<FilmSource>,
    /// Fibres: colour and roughness.
    pub sheen: Option<(ColourSource, FactorSource)>,
    /// Clear coat.
    pub coat: Option<CoatSource>,
}

impl SceneTraits for LayeredMaterial {
    fn disperses(&self) -> bool {
        self.dispersive
    }

    fn may_pass_straight(&self) -> bool {
        // A texture may make it polished.
        let is_smooth = |roughness: f32| Ggx::new(roughness * roughness, roughness * roughness).is_smooth();
        let may_be_smooth = self.roughness.texture.is_some() || is_smooth(self.roughness.value);
        // Of index 1 nothing is reflected: a volume that only absorbs.
        let is_pane = if self.has_volume { self.f0 == 0.0 && !self.dispersive } else { may_be_smooth };
        self.transmission.value > 0.0 && is_pane
    }

    fn may_cast_caustics(&self) -> bool {
        // Textures only make it smoother.
        let may_be_near_specular = |roughness: FactorSource| {
            let alpha = roughness.value * roughness.value;
            roughness.texture.is_some() || Ggx::new(alpha, alpha).is_near_specular()
        };
        may_be_near_specular(self.roughness)
            || self.coat.is_some_and(|coat| may_be_near_specular(coat.roughness))
            || self.has_volume && self.transmission.value > 0.0
    }
}

/// Grooves, which make roughness anisotropic.
#[derive(Clone, Copy, Debug)]
pub struct AnisotropySource {
    /// Strength of the grooves, 0–1.
    pub strength: f32,
    /// Cosine and sine of the rotation of the rougher direction from the tangent.
    pub rotation: [f32; 2],
    /// Handle of a linear texture: R, G direction, B strength.
    pub texture: Option<u32>,
}

/// A thin film.
#[derive(Clone, Copy, Debug)]
pub struct FilmSource {
    /// Part of the surface that the film covers, 0–1.
    pub weight: FactorSource,
    /// Refractive index.
    pub index: f32,
    /// Thickness where the texture is 0 and where it is 1, nm.
    pub thickness_nm: [f32; 2],
    /// Handle of a linear texture whose green channel places the thickness between the two of `thickness_nm`; `None`
    /// for the second.
    pub texture: Option<u32>,
}

/// Clear coat.
#[derive(Clone, Copy, Debug)]
pub struct CoatSource {
    /// Weight of the coat, 0–1.
    pub weight: FactorSource,
    /// Perceptual roughness.
    pub roughness: FactorSource,
    /// Normal map of the coat.
    pub normal_map: Option<NormalMap>,
}

/// A tangent-space normal map.
#[derive(Clone, Copy, Debug)]
pub struct NormalMap {
    /// Handle of a linear texture.
    pub texture: u32,
    /// Scale of x and y.
    pub scale: f32,
}

/// Alpha mode of a surface, with its parameters.
#[derive(Clone, Copy, Debug)]
pub enum Alpha {
    /// Opaque surface, which is there everywhere.
    Opaque,
    /// Surface that is there where alpha ≥ cutoff.
    Mask {
        /// Alpha factor.
        factor: f32,
        /// Texture whose alpha multiplies it.
        texture: Option<u32>,
        /// Threshold of alpha.
        cutoff: f32,
    },
    /// Surface that is there with probability alpha.
    Blend {
        /// Alpha factor.
        factor: f32,
        /// Texture whose alpha multiplies it.
        texture: Option<u32>,
    },
}
