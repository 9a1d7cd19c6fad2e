//! The layers at one point of a surface.

use glam::Vec3;

use super::ThinFilm;
use crate::bsdf::microfacet::Ggx;
use photosite_core::spectrum::SampledSpectrum;

/// The layers at one point of a surface. The default is glTF's: white, not metallic, polished, of index 1.5.
#[derive(Clone, Copy, Debug)]
pub struct Layered {
    /// Base colour, 0–1: F₀ of the metal, ρ of the coloured base, tint of transmission.
    pub base_colour: SampledSpectrum,
    /// Metalness: 0 for no metal, 1 for metal.
    pub metallic: f32,
    /// Roughness of the facets.
    pub distribution: Ggx,
    /// Weight of the facets' reflection where there is no metal, 0–1 (`specular`).
    pub specular: f32,
    /// Reflectance of the facets at normal incidence, 0–1.
    pub f0: SampledSpectrum,
    /// The part of the light let in that goes straight on or is refracted, 0–1.
    pub transmission: f32,
    /// Medium behind the surface, if it bounds a volume that transmitted light enters.
    pub volume: Option<Volume>,
    /// The part of the other light let in that comes out behind, 0–1.
    pub diffuse_transmission: f32,
    /// Colour of diffuse transmission, 0–1.
    pub diffuse_transmission_colour: SampledSpectrum,
    /// A thin film on the facets.
    pub film: Option<ThinFilm>,
    /// Layer of fibres.
    pub sheen: Option<Sheen>,
    /// Clear coat over all other layers.
    pub coat: Option<Coat>,
}

/// A clear medium on the side that +Z points away from.
#[derive(Clone, Copy, Debug)]
pub struct Volume {
    /// Relative refractive index n_inside/n_outside. Equal in all lanes unless dispersive.
    pub eta: SampledSpectrum,
    /// Whether the index depends on wavelength.
    pub dispersive: bool,
}

/// Fibres that stand on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Sheen {
    /// Colour of the fibres, 0–1.
    pub colour: SampledSpectrum,
    /// Roughness α = roughness² of the fibres.
    pub alpha: f32,
}

/// A clear coat of index 1.5.
#[derive(Clone, Copy, Debug)]
pub struct Coat {
    /// Weight of the coat, 0–1.
    pub weight: f32,
    /// Isotropic roughness of the coat.
    pub distribution: Ggx,
    /// Unit normal of the coat in the local frame.
    pub normal: Vec3,
}

impl Default for Layered {
    fn default() -> Self {
        Self {
            base_colour: SampledSpectrum::ONE,
            metallic: 0.0,
            distribution: Ggx::SMOOTH,
            specular: 1.0,
            f0: SampledSpectrum::splat(0.04),
            transmission: 0.0,
            volume: None,
            diffuse_transmission: 0.0,
            diffuse_transmission_colour: SampledSpectrum::ONE,
            film: None,
            sheen: None,
            coat: None,
        }
    }
}

impl Layered {
    /// The parts of the base: metal, coloured, clear.
    #[inline]
    pub(super) fn parts(&self) -> [f32; 3] {
        let other = 1.0 - self.metallic;
        [self.metallic, other * (1.0 - self.transmission), other * self.transmission]
    }

    /// The volume behind, where light gets into it by refraction.
    #[inline]
    pub(super) fn refracting(&self) -> Option<Volume> {
        self.volume.filter(|_| self.transmission > 0.0)
    }

    /// Whether both sides scatter alike.
    #[inline]
    pub fn is_two_sided(&self) -> bool {
        self.refracting().is_none()
    }

    #[inline]
    pub(super) fn transmits(&self) -> bool {
        self.metallic < 1.0 && (self.transmission > 0.0 || self.diffuse_transmission > 0.0)
    }

    #[inline]
    pub(super) fn is_delta(&self) -> bool {
        let [_, coloured, _] = self.parts();
        self.distribution.is_smooth()
            && coloured == 0.0
            && self.sheen.is_none()
            && self.coat.is_none_or(|coat| coat.distribution.is_smooth())
    }
}
