//! Diffuse surfaces with relief: plaster, clay, the moon. Facets that scatter by Lambert's law and shadow each other.
//!
//! Oren and Nayar's model in Fujii's form, with what it loses between the facets given back
//! ([Portsmouth25](photosite_core::references#portsmouth25)). With s = wo·wi − cos θₒ·cos θᵢ, t = max(cos θₒ, cos θᵢ)
//! where s is positive and 1 elsewhere, roughness r and A = 1/(1 + (1/2 − 2/3π)·r), one bounce is f₁ = ρ/π·A·(1 +
//! r·s/t), of which a white surface gives back
//!
//! E(θ) = A·(1 + r·G(θ)/π), G = sin θ·(θ − sin θ·cos θ) + ⅔·(tan θ·(1 − sin³θ) − sin θ), Ē = A·(1 + (2/3 − 28/15π)·r).
//!
//! The bounces after it are f₂ = ρ²·Ē/(1 − ρ(1 − Ē))·(1 − E(θₒ))·(1 − E(θᵢ))/(π·(1 − Ē)). r = 0 is Lambert's law.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::directions::is_above;
use super::form::{Form, Map, Sampled, TableForm};
use super::lobe::{Lobe, SceneTraits, Traits};
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::math::{Pdf, warp};
use photosite_core::spectrum::SampledSpectrum;

const C1: f32 = 0.5 - 2.0 / 3.0 * FRAC_1_PI;
const C2: f32 = 2.0 / 3.0 - 28.0 / 15.0 * FRAC_1_PI;

/// Loss in all below which it counts as rounding.
const NOTHING_LOST: f32 = 1e-5;

/// Part of the samples drawn evenly over the hemisphere, not by the cosine: light scattered back along the surface
/// needs it.
const EVEN_PART: f32 = 0.5;

/// A diffuse surface with relief.
#[derive(Clone, Copy, Debug)]
pub struct OrenNayar<F: Form = Sampled> {
    /// Reflectance ρ, 0–1.
    pub reflectance: F::Colour,
    /// Roughness, 0–1; 0 is Lambert's law.
    pub roughness: f32,
}

impl<F: Form> OrenNayar<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> OrenNayar<T> {
        OrenNayar { reflectance: map.colour(&self.reflectance), roughness: self.roughness }
    }
}

impl<F: TableForm> SceneTraits for OrenNayar<F> {}

impl Lobe for OrenNayar {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        if !(is_above(wo) && is_above(wi)) {
            return BsdfEval::ZERO;
        }
        let &Self { reflectance, roughness } = self;
        let a = 1.0 / (1.0 + C1 * roughness);
        let s = wo.dot(wi) - wo.z * wi.z;
        let t = if s > 0.0 { wo.z.max(wi.z) } else { 1.0 };
        // Where both graze the surface and s is minus the product of the sines, rounding may go below 0.
        let mut f = reflectance * (a * (1.0 + roughness * s / t)).max(0.0);
        let mean = a * (1.0 + C2 * roughness);
        if 1.0 - mean > NOTHING_LOST {
            let lost = |z: f32| (1.0 - a * (1.0 + roughness * FRAC_1_PI * g(z))).max(0.0);
            let bounced = reflectance * reflectance * mean / (SampledSpectrum::ONE - reflectance * (1.0 - mean));
            f += bounced * (lost(wo.z) * lost(wi.z) / (1.0 - mean));
        }
        BsdfEval { f: f * FRAC_1_PI, pdf: Pdf::new(((1.0 - EVEN_PART) * wi.z + EVEN_PART * 0.5) * FRAC_1_PI) }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = if u_lobe < EVEN_PART { warp::uniform_cone(u, 0.0) } else { warp::cosine_hemisphere(u).into() };
        let BsdfEval { f, pdf } = self.eval(wo, wi);
        (pdf.0 > 0.0).then(|| BsdfSample::reflected(f, wi, pdf))
    }

    #[inline]
    fn traits(&self) -> Traits {
        Traits { has_lobes: true, ..Traits::default() }
    }
}

/// Function G at the cosine `z`.
#[inline]
fn g(z: f32) -> f32 {
    let z = z.min(1.0);
    let sin = (1.0 - z * z).max(0.0).sqrt();
    // tan θ·(1 − sin³θ), in which 1 − sin θ = cos²θ/(1 + sin θ).
    let last = sin * z * (1.0 + sin + sin * sin) / (1.0 + sin);
    sin * ((PI / 2.0 - z.asin()) - sin * z) + 2.0 / 3.0 * (last - sin)
}
