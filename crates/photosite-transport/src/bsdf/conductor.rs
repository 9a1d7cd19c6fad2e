//! Metals: GGX facets, each a mirror with the exact Fresnel reflectance of the complex index η + i·k.
//!
//! f = F(wo·m)·D(m)·G₂(wo, wi)/(4·cos θₒ·cos θᵢ) with m the half vector ([Walter07](photosite_core::references#walter07)
//! eq. 20), for wo and wi above the surface. Light that bounces more than once between facets is lost: the model
//! reflects too little where α comes near 1. Polished, it is a mirror.

use glam::Vec3;

use super::fresnel;
use super::microfacet::Ggx;
use super::{BsdfEval, BsdfSample, is_above};
use photosite_core::math::Pdf;
use photosite_core::spectrum::SampledSpectrum;

#[inline]
pub(super) fn eval(eta: SampledSpectrum, k: SampledSpectrum, distribution: Ggx, wo: Vec3, wi: Vec3) -> BsdfEval {
    if distribution.is_smooth() || !(is_above(wo) && is_above(wi)) {
        return BsdfEval::ZERO;
    }
    let kernel = distribution.reflection(wo, wi);
    BsdfEval { f: fresnel::conductor(kernel.cos_facet, eta, k) * kernel.value, pdf: Pdf::new(kernel.pdf) }
}

#[inline]
pub(super) fn sample(
    eta: SampledSpectrum,
    k: SampledSpectrum,
    distribution: Ggx,
    wo: Vec3,
    u: [f32; 2],
) -> Option<BsdfSample> {
    if !is_above(wo) {
        return None;
    }
    if distribution.is_smooth() {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        return Some(BsdfSample::mirrored(fresnel::conductor(wo.z.min(1.0), eta, k), wi, 1.0));
    }
    let (wi, kernel) = distribution.sample_reflection(wo, u)?;
    let f = fresnel::conductor(kernel.cos_facet, eta, k) * kernel.value;
    Some(BsdfSample::reflected(f, wi, Pdf::new(kernel.pdf)))
}
