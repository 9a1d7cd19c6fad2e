//! Thin matt sheets: paper, leaves, lamp shades. Lambert's law on both sides, f = ρ/π where light is reflected and τ/π
//! where it comes out behind, ρ + τ at most 1. These are what a spectrometer with an integrating sphere measures.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::dielectric::mirrored;
use super::{BsdfEval, BsdfSample, is_above, is_grazing};
use photosite_core::math::{Pdf, warp};
use photosite_core::spectrum::SampledSpectrum;

/// The part of the samples that stay on the side of `wo`; None where all is black.
#[inline]
fn reflected_part(reflectance: SampledSpectrum, transmittance: SampledSpectrum) -> Option<f32> {
    let sum = reflectance.mean() + transmittance.mean();
    (sum > 0.0).then(|| reflectance.mean() / sum)
}

#[inline]
pub(super) fn eval(reflectance: SampledSpectrum, transmittance: SampledSpectrum, wo: Vec3, wi: Vec3) -> BsdfEval {
    let Some(part) = reflected_part(reflectance, transmittance).filter(|_| is_above(wo) && !is_grazing(wi)) else {
        return BsdfEval::ZERO;
    };
    let (albedo, part) = if wi.z > 0.0 { (reflectance, part) } else { (transmittance, 1.0 - part) };
    let pdf = part * wi.z.abs() * FRAC_1_PI;
    if pdf > 0.0 { BsdfEval { f: albedo * FRAC_1_PI, pdf: Pdf::new(pdf) } } else { BsdfEval::ZERO }
}

#[inline]
pub(super) fn sample(
    reflectance: SampledSpectrum,
    transmittance: SampledSpectrum,
    wo: Vec3,
    u_lobe: f32,
    u: [f32; 2],
) -> Option<BsdfSample> {
    let is_transmission = u_lobe >= reflected_part(reflectance, transmittance)?;
    let up = Vec3::from(warp::cosine_hemisphere(u));
    let wi = if is_transmission { mirrored(up) } else { up };
    let BsdfEval { f, pdf } = eval(reflectance, transmittance, wo, wi);
    (pdf.0 > 0.0).then(|| BsdfSample { is_transmission, ..BsdfSample::reflected(f, wi, pdf) })
}
