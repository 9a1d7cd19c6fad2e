//! Phong's model in the form that conserves energy and is reciprocal
//! ([LafortuneWillems94](photosite_core::references#lafortunewillems94)):
//!
//! f = ρ_d/π + ρ_s·(n + 2)/(2π)·cosⁿα, α the angle between `wi` and the mirror direction of `wo`.
//!
//! ρ_d + ρ_s is at most 1. No surface scatters so; it is here to be compared with what textbooks compute.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;

use super::directions::is_above;
use super::form::{Form, Map, Sampled, TableForm};
use super::lobe::{Lobe, SceneTraits, Traits};
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::math::{Frame, Pdf, warp};

/// Phong's model.
#[derive(Clone, Copy, Debug)]
pub struct Phong<F: Form = Sampled> {
    /// Diffuse reflectance ρ_d, the part of the light that is scattered by Lambert's law, 0–1.
    pub diffuse: F::Colour,
    /// Specular reflectance ρ_s, the part of the light in the lobe, 0–1; ρ_d + ρ_s is at most 1.
    pub specular: F::Colour,
    /// Exponent n of the lobe, at least 0.
    pub exponent: f32,
}

impl<F: Form> Phong<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> Phong<T> {
        let (diffuse, specular) = (map.colour(&self.diffuse), map.colour(&self.specular));
        Phong { diffuse, specular, exponent: self.exponent }
    }
}

impl<F: TableForm> SceneTraits for Phong<F> {
    fn may_cast_caustics(&self) -> bool {
        is_near_specular(self.exponent)
    }
}

/// Whether the lobe of an exponent is as narrow as that of microfacets of which
/// [`Ggx::is_near_specular`](super::Ggx::is_near_specular) says so: their α is √(2/(n + 2)).
#[inline]
fn is_near_specular(exponent: f32) -> bool {
    exponent > 20.0
}

impl Phong {
    /// The part of the samples that go to the lobe; None where all is black.
    #[inline]
    fn lobe_part(&self) -> Option<f32> {
        let [diffuse, specular] = [self.diffuse.mean(), self.specular.mean()];
        let sum = diffuse + specular;
        (sum > 0.0).then(|| specular / sum)
    }
}

impl Lobe for Phong {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let Some(lobe) = self.lobe_part().filter(|_| is_above(wo) && is_above(wi)) else { return BsdfEval::ZERO };
        let power = mirrored(wo).dot(wi).clamp(0.0, 1.0).powf(self.exponent);
        let f = self.diffuse * FRAC_1_PI + self.specular * ((self.exponent + 2.0) / TAU * power);
        let pdf = (1.0 - lobe) * wi.z * FRAC_1_PI + lobe * (self.exponent + 1.0) / TAU * power;
        if pdf > 0.0 { BsdfEval { f, pdf: Pdf::new(pdf) } } else { BsdfEval::ZERO }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, [u, v]: [f32; 2]) -> Option<BsdfSample> {
        let wi = if u_lobe < self.lobe_part()? {
            let cos = (1.0 - v).powf(1.0 / (self.exponent + 1.0));
            let (sin_phi, cos_phi) = (TAU * u).sin_cos();
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            Frame::from_normal(mirrored(wo)).to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos))
        } else {
            warp::cosine_hemisphere([u, v]).into()
        };
        let BsdfEval { f, pdf } = self.eval(wo, wi);
        (pdf.0 > 0.0).then(|| BsdfSample::reflected(f, wi, pdf))
    }

    #[inline]
    fn traits(&self) -> Traits {
        let casts_caustics = is_near_specular(self.exponent) && !self.specular.is_black();
        Traits { has_lobes: true, casts_caustics, ..Traits::default() }
    }
}

#[inline]
fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(-w.x, -w.y, w.z)
}
