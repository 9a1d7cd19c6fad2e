//! glTF's material with all that its extensions add: layers over a base that may be metal, coloured, or clear.
//!
//! From the glTF 2.0 specification, appendix B ([Gltf2](photosite_core::references#gltf2)), and the extensions
//! `KHR_materials_*` that it links to. From the top down:
//!
//! | layer | what it does | from |
//! |---|---|---|
//! | coat | GGX reflection, F₀ = 0.04, with a normal of its own | `clearcoat` |
//! | sheen | fibres (`sheen`) | `sheen` |
//! | facets | GGX reflection: Schlick's Fresnel factor, or that of a film (`film`) | appendix B, `ior`, `specular`, `iridescence`, `anisotropy` |
//! | base | nothing (metal), Lambert reflection, Lambert transmission, straight or refracted transmission | appendix B, `transmission`, `volume`, `dispersion`, `diffuse_transmission` |
//!
//! α = roughness². The parts of the base are mixed as "metallic" (m) and "transmission" (t) say: metal m, coloured
//! (1 − m)(1 − t), clear (1 − m)·t. With k = D·G₂/(4·cos θₒ·cos θᵢ) the lobes of single directions are
//!
//! - coat c·F(0.04)·k_c, sheen s·D·G/(4·cos θₒ·cos θᵢ) below the coat, facets F·k below both;
//! - clear and thin: (1 − F)·base·k with `wi` mirrored back to the side of `wo` (`transmission`, "Transmission BTDF");
//! - clear with a volume behind: F and refraction of a rough interface (`dielectric`), with the exact
//!   Fresnel factor in place of Schlick's weight, since there is total reflection from inside.
//!
//! **Layers.** What lies under a layer of directional albedo E is multiplied by 1 − max(E(wo), E(wi)), the reciprocal
//! form of `sheen`, "Albedo-scaling technique": no direction gets more than the layer lets through.
//!
//! **What is left.** All that the lobes above do not reflect, R(w) = 1 − ΣE(w), comes out of the base as
//! ρ/π·R(wo)·R(wi)/R̄ ([Kelemen01](photosite_core::references#kelemen01)), R̄ its mean over the hemisphere. That is reciprocal, and a
//! white material gives back what arrives, all of it, at every angle and roughness, since R of each part counts the
//! light that bounces between facets and layers as let in. ρ is
//!
//! - the base colour, and the colour of diffuse transmission on the other side;
//! - for a metal F̄²·Ē/(1 − F̄(1 − Ē)), the colour after further bounces between facets
//!   ([KullaConty17](photosite_core::references#kullaconty17));
//! - for a clear base F̄ reflected and (1 − F̄)·base transmitted; with a volume behind both sides share it so that
//!   reciprocity holds.
//!
//! **Where it departs from the specification:** the appendix's implementation, a sample and not normative, lets the light
//! that a facet does not reflect reach the base, 1 − F(wo·m), as if all light that leaves the base had come in by that facet.
//! A smooth white surface seen from 80° then gives back 1.35 times what arrives. It also loses the light that bounces
//! twice between facets.
//!
//! Sheen attenuates wavelength by wavelength, not by its largest channel. Coat and sheen lie on both sides of thin
//! surfaces that transmit, and on all but the clear part of those that bound a volume. A coat with a normal of its own
//! is not reciprocal, as no mapped normal is. Facets that refract give back up to 4 % too much or too little where they are
//! anisotropic, as exact as their table is.

mod film;
pub(super) mod sheen;
mod view;

use glam::Vec3;

pub use film::Film;

use super::dielectric::{self, mirrored};
use super::microfacet::Ggx;
use super::model::Traits;
use super::{BsdfEval, BsdfSample, is_grazing};
use photosite_core::spectrum::SampledSpectrum;
use view::View;

/// The layers at one point of a surface. The default is glTF's: white, not metallic, polished, of index 1.5.
#[derive(Clone, Copy, Debug)]
pub struct Layered {
    /// 0–1: F₀ of the metal, ρ of the coloured base, tint of transmission.
    pub base_colour: SampledSpectrum,
    /// 0 no metal, 1 metal.
    pub metallic: f32,
    /// Roughness of the facets.
    pub distribution: Ggx,
    /// Weight of the facets' reflection where there is no metal, 0–1 (`specular`).
    pub specular: f32,
    /// Their reflectance at normal incidence, 0–1.
    pub f0: SampledSpectrum,
    /// The part of the light let in that goes straight on or is refracted, 0–1.
    pub transmission: f32,
    /// What is behind the surface, if it bounds a volume that light gets into by transmission.
    pub volume: Option<Volume>,
    /// The part of the other light let in that comes out behind, 0–1.
    pub diffuse_transmission: f32,
    /// Its colour, 0–1.
    pub diffuse_transmission_colour: SampledSpectrum,
    /// A thin film on the facets.
    pub film: Option<Film>,
    /// Fibres.
    pub sheen: Option<Sheen>,
    /// Varnish over all.
    pub coat: Option<Coat>,
}

/// A clear medium on the side that +Z points away from.
#[derive(Clone, Copy, Debug)]
pub struct Volume {
    /// n_inside/n_outside. Equal in all lanes unless dispersive.
    pub eta: SampledSpectrum,
    /// Whether the index depends on wavelength.
    pub dispersive: bool,
}

/// Fibres that stand on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Sheen {
    /// 0–1.
    pub colour: SampledSpectrum,
    /// roughness².
    pub alpha: f32,
}

/// A clear coat of index 1.5.
#[derive(Clone, Copy, Debug)]
pub struct Coat {
    /// 0–1.
    pub weight: f32,
    /// Its roughness, isotropic.
    pub distribution: Ggx,
    /// Its unit normal in the local frame.
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
    fn parts(&self) -> [f32; 3] {
        let other = 1.0 - self.metallic;
        [self.metallic, other * (1.0 - self.transmission), other * self.transmission]
    }

    /// The volume behind, where light gets into it by refraction.
    #[inline]
    fn refracting(&self) -> Option<Volume> {
        self.volume.filter(|_| self.transmission > 0.0)
    }

    /// Whether both sides are alike.
    #[inline]
    pub fn is_two_sided(&self) -> bool {
        self.refracting().is_none()
    }

    #[inline]
    fn transmits(&self) -> bool {
        self.metallic < 1.0 && (self.transmission > 0.0 || self.diffuse_transmission > 0.0)
    }

    #[inline]
    fn is_delta(&self) -> bool {
        let [_, coloured, _] = self.parts();
        self.distribution.is_smooth()
            && coloured == 0.0
            && self.sheen.is_none()
            && self.coat.is_none_or(|coat| coat.distribution.is_smooth())
    }

    #[inline]
    pub(super) fn traits(&self) -> Traits {
        let refracts_smoothly = |volume: Volume| dielectric::is_delta(volume.eta, self.distribution);
        Traits {
            has_lobes: true,
            transmits: self.transmits(),
            is_delta: self.is_delta(),
            casts_caustics: self.distribution.is_near_specular()
                || self.coat.is_some_and(|coat| coat.distribution.is_near_specular())
                || self.refracting().is_some_and(refracts_smoothly),
            needs_single_wavelength: self.refracting().is_some_and(|v| v.dispersive && !refracts_smoothly(v)),
        }
    }

    #[inline]
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let is_inside = wo.z < 0.0;
        if is_grazing(wo) || is_grazing(wi) || self.is_delta() || is_inside && self.is_two_sided() {
            return BsdfEval::ZERO;
        }
        let (wo, wi) = if is_inside { (mirrored(wo), mirrored(wi)) } else { (wo, wi) };
        if wi.z < 0.0 && !self.transmits() {
            return BsdfEval::ZERO;
        }
        View::new(self, wo, is_inside).map_or(BsdfEval::ZERO, |view| view.eval(wi))
    }

    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let is_inside = wo.z < 0.0;
        if is_grazing(wo) || is_inside && self.is_two_sided() {
            return None;
        }
        let sample = View::new(self, if is_inside { mirrored(wo) } else { wo }, is_inside)?.sample(u_lobe, u)?;
        Some(if is_inside { BsdfSample { wi: mirrored(sample.wi), ..sample } } else { sample })
    }
}
