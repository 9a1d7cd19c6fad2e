//! Materials as light transport reads them: handles instead of descriptions.

use crate::bsdf::{Diffuse, Form, Ggx, Model, RelativeIndex, SceneTraits, TableForm};
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
    pub(super) fn only_reflectance(&self) -> Option<ColourSource> {
        let Model::Diffuse(Diffuse { reflectance }) = self.model else { return None };
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
