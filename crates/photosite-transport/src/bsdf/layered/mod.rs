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
//! - clear with a volume behind: F and refraction of a rough interface (`refraction`), with the exact
//!   Fresnel factor in place of Schlick's weight, since there is total reflection from inside.
//!
//! **Layers.** What lies under a layer of directional albedo E is multiplied by 1 − max(E(wo), E(wi)), the reciprocal
//! form of `sheen`, "Albedo-scaling technique": no direction gets more than the layer lets through.
//!
//! **What is left.** All that the lobes above do not reflect, R(w) = 1 − ΣE(w), comes out of the base as
//! ρ/π·R(wo)·R(wi)/R̄ ([Kelemen01](photosite_core::references#kelemen01)), R̄ its mean over the hemisphere. That is
//! reciprocal, and a white material gives back what arrives, all of it, at every angle and roughness, since R of each
//! part counts the light that bounces between facets and layers as let in. ρ is
//!
//! - the base colour, and the colour of diffuse transmission on the other side;
//! - for a metal F̄²·Ē/(1 − F̄(1 − Ē)), the colour after further bounces between facets
//!   ([KullaConty17](photosite_core::references#kullaconty17));
//! - for a clear base F̄ reflected and (1 − F̄)·base transmitted; with a volume behind both sides share it so that
//!   reciprocity holds.
//!
//! **Where it departs from the specification:** the appendix's implementation, a sample and not normative, lets the
//! light that a facet does not reflect reach the base, 1 − F(wo·m), as if all light that leaves the base had come in by
//! that facet. A smooth white surface seen from 80° then gives back 1.35 times what arrives. It also loses the light
//! that bounces twice between facets.
//!
//! Sheen of low roughness is scaled where it would give back more than arrives, see `sheen`. It attenuates wavelength by
//! wavelength, not by its largest channel. Coat and sheen lie on both sides of thin
//! surfaces that transmit, and on all but the clear part of those that bound a volume. A coat with a normal of its own
//! is not reciprocal, as no mapped normal is. Facets that refract give back up to 4 % too much or too little where they
//! are anisotropic, as exact as their table is.

mod layers;
mod thin_film;
mod view;

use glam::Vec3;

use super::directions::{is_grazing, mirrored};
use super::lobe::Traits;
use super::refraction;
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::spectrum::SampledSpectrum;
use view::View;

pub use layers::{Coat, Layered, Sheen, Volume};
pub use thin_film::ThinFilm;

impl Layered {
    #[inline]
    pub(super) fn traits(&self) -> Traits {
        let refracts_smoothly = |volume: Volume| refraction::is_delta(volume.eta, self.distribution);
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
    pub(super) fn straight(&self, wo: Vec3) -> SampledSpectrum {
        let is_inside = wo.z < 0.0;
        let goes_straight = match self.refracting() {
            None => self.distribution.is_smooth() && !is_inside,
            Some(volume) => volume.eta == SampledSpectrum::ONE,
        };
        if self.transmission <= 0.0 || !goes_straight || is_grazing(wo) {
            return SampledSpectrum::ZERO;
        }
        let view = View::new(self, if is_inside { mirrored(wo) } else { wo }, is_inside);
        let sample = view.and_then(|view| view.pass_undisturbed());
        sample.map_or(SampledSpectrum::ZERO, |sample| sample.f * sample.wi.z.abs())
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
