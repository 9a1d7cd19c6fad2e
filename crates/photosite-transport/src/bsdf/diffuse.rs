//! Lambert's law: light leaves in all directions with the same radiance.
//!
//! f = ρ/π for wo and wi above the surface. The reflectance ρ is between 0 and 1; it is at the same time the albedo for
//! every direction.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::{BsdfEval, BsdfSample, is_above};
use photosite_core::math::{Pdf, warp};
use photosite_core::spectrum::SampledSpectrum;

#[inline]
pub(super) fn eval(reflectance: SampledSpectrum, wo: Vec3, wi: Vec3) -> BsdfEval {
    if !(is_above(wo) && is_above(wi)) {
        return BsdfEval::ZERO;
    }
    BsdfEval { f: reflectance * FRAC_1_PI, pdf: Pdf::new(wi.z * FRAC_1_PI) }
}

#[inline]
pub(super) fn sample(reflectance: SampledSpectrum, wo: Vec3, u: [f32; 2]) -> Option<BsdfSample> {
    let wi = Vec3::from(warp::cosine_hemisphere(u));
    (is_above(wo) && is_above(wi))
        .then(|| BsdfSample::reflected(reflectance * FRAC_1_PI, wi, Pdf::new(wi.z * FRAC_1_PI)))
}
