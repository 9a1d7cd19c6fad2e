//! Thin diffuse sheets: paper, leaves, lamp shades. Lambert's law on both sides, f = ρ/π where light is reflected and
//! τ/π where it comes out behind, ρ + τ at most 1. These are what a spectrometer with an integrating sphere measures.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::directions::{is_above, is_grazing, mirrored};
use super::form::{Form, Map, Sampled, TableForm};
use super::lobe::{Lobe, SceneTraits, Traits};
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::math::{Pdf, warp};

/// A thin diffuse sheet.
#[derive(Clone, Copy, Debug)]
pub struct Translucent<F: Form = Sampled> {
    /// Reflectance ρ, 0–1.
    pub reflectance: F::Colour,
    /// Transmittance τ, 0–1; with the reflectance at most 1.
    pub transmittance: F::Colour,
}

impl<F: Form> Translucent<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> Translucent<T> {
        let (reflectance, transmittance) = (map.colour(&self.reflectance), map.colour(&self.transmittance));
        Translucent { reflectance, transmittance }
    }
}

impl<F: TableForm> SceneTraits for Translucent<F> {}

impl Translucent {
    /// The part of the samples that stay on the side of `wo`; None where all is black.
    #[inline]
    fn reflected_part(&self) -> Option<f32> {
        let sum = self.reflectance.mean() + self.transmittance.mean();
        (sum > 0.0).then(|| self.reflectance.mean() / sum)
    }
}

impl Lobe for Translucent {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let Some(part) = self.reflected_part().filter(|_| is_above(wo) && !is_grazing(wi)) else {
            return BsdfEval::ZERO;
        };
        let (albedo, part) = if wi.z > 0.0 { (self.reflectance, part) } else { (self.transmittance, 1.0 - part) };
        let pdf = part * wi.z.abs() * FRAC_1_PI;
        if pdf > 0.0 { BsdfEval { f: albedo * FRAC_1_PI, pdf: Pdf::new(pdf) } } else { BsdfEval::ZERO }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let is_transmission = u_lobe >= self.reflected_part()?;
        let up = Vec3::from(warp::cosine_hemisphere(u));
        let wi = if is_transmission { mirrored(up) } else { up };
        let BsdfEval { f, pdf } = self.eval(wo, wi);
        (pdf.0 > 0.0).then(|| BsdfSample { is_transmission, ..BsdfSample::reflected(f, wi, pdf) })
    }

    #[inline]
    fn traits(&self) -> Traits {
        Traits { has_lobes: true, transmits: true, ..Traits::default() }
    }
}
