//! Metals: GGX facets, each a mirror with the exact Fresnel reflectance of the complex index η + i·k.
//!
//! f = F(wo·m)·D(m)·G₂(wo, wi)/(4·cos θₒ·cos θᵢ) with m the half vector
//! ([Walter07](photosite_core::references#walter07) eq. 20), for wo and wi above the surface. Light that bounces more
//! than once between facets is lost: the model reflects too little where α comes near 1. Polished, it is a mirror.

use glam::Vec3;

use super::directions::is_above;
use super::form::{Form, Map, Sampled, TableForm};
use super::fresnel;
use super::lobe::{Lobe, SceneTraits, Traits};
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::math::Pdf;

/// A metal.
#[derive(Clone, Copy, Debug)]
pub struct Conductor<F: Form = Sampled> {
    /// Real part of the refractive index, relative to the medium outside.
    pub eta: F::Spectrum,
    /// Imaginary part (extinction coefficient), relative to the medium outside.
    pub k: F::Spectrum,
    /// Roughness of its microfacets.
    pub distribution: F::Distribution,
}

impl<F: Form> Conductor<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> Conductor<T> {
        let (eta, k) = (map.spectrum(&self.eta), map.spectrum(&self.k));
        Conductor { eta, k, distribution: map.distribution(&self.distribution) }
    }
}

impl<F: TableForm> SceneTraits for Conductor<F> {
    fn may_cast_caustics(&self) -> bool {
        self.distribution.is_near_specular()
    }
}

impl Lobe for Conductor {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        if self.distribution.is_smooth() || !(is_above(wo) && is_above(wi)) {
            return BsdfEval::ZERO;
        }
        let kernel = self.distribution.reflection(wo, wi);
        let f = fresnel::conductor(kernel.cos_facet, self.eta, self.k) * kernel.value;
        BsdfEval { f, pdf: Pdf::new(kernel.pdf) }
    }

    #[inline]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !is_above(wo) {
            return None;
        }
        if self.distribution.is_smooth() {
            let wi = Vec3::new(-wo.x, -wo.y, wo.z);
            return Some(BsdfSample::mirrored(fresnel::conductor(wo.z.min(1.0), self.eta, self.k), wi, 1.0));
        }
        let (wi, kernel) = self.distribution.sample_reflection(wo, u)?;
        let f = fresnel::conductor(kernel.cos_facet, self.eta, self.k) * kernel.value;
        Some(BsdfSample::reflected(f, wi, Pdf::new(kernel.pdf)))
    }

    #[inline]
    fn traits(&self) -> Traits {
        Traits {
            is_delta: self.distribution.is_smooth(),
            casts_caustics: self.distribution.is_near_specular(),
            ..Traits::default()
        }
    }
}
