//! glTF's metallic-roughness material: a metal, or a coloured base under a clear coat, or a mixture.
//!
//! From the glTF 2.0 specification, appendix B ([Gltf2](crate::references#gltf2)): α = roughness², GGX facets with
//! height-correlated Smith masking, Schlick's Fresnel factor with F₀ = 0.04 for the coat and the base colour for the
//! metal, and material = mix(coated base, metal, metallic). With S(F₀) = (F₀ + (1 − F₀)(1 − wo·m)⁵)·D·G₂/(4·cos θₒ·cos θᵢ),
//!
//! f = (1 − metallic)·(S(0.04) + base/π·K) + metallic·S(base).
//!
//! **Where it departs from the specification:** the appendix lets the light that a facet does not reflect reach the base,
//! K = 1 − F(wo·m), as if all light that leaves the base had come in by that facet. A smooth white surface seen from 80°
//! then gives back 1.35 times what arrives. Here the base gets what the coat as a whole lets in and out
//! ([Kelemen01](crate::references#kelemen01)),
//!
//! K = (1 − E(cos θₒ))·(1 − E(cos θᵢ))/(1 − Ē),
//!
//! with E the directional albedo of S(0.04) and Ē its mean. That is reciprocal as well, and a white base gives back
//! what arrives, all of it, at every angle and roughness: what bounces between the facets of the coat counts as let in. The
//! appendix's implementation is a sample, not normative.
//!
//! As in the appendix, light that bounces between the facets of a metal is lost.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::albedo::Row;
use super::fresnel::schlick_weight;
use super::microfacet::{Ggx, ReflectionKernel};
use super::{BsdfEval, BsdfSample, is_above};
use crate::math::{Pdf, warp};
use crate::spectrum::SampledSpectrum;

/// Reflectance of the coat at normal incidence: an index of 1.5.
const COAT_F0: f32 = 0.04;

/// The material as seen from one direction.
struct Seen {
    /// F₀ of coat and metal together: Schlick's factor is linear in it.
    f0: SampledSpectrum,
    /// What lies under the coat; none where it is black or all is metal.
    base: Option<Base>,
    /// Probability of sampling the facets rather than the base: their share of what is reflected.
    facet_probability: f32,
}

struct Base {
    /// (1 − metallic)·base/π·(1 − E(cos θₒ))/(1 − Ē).
    seen: SampledSpectrum,
    /// E of the coat, for light on its way in.
    coat: Row,
}

impl Seen {
    #[inline]
    fn new(base_colour: SampledSpectrum, metallic: f32, distribution: Ggx, cos_o: f32) -> Self {
        let f0 = SampledSpectrum::splat(COAT_F0 * (1.0 - metallic)) + base_colour * metallic;
        if metallic >= 1.0 || base_colour.is_black() {
            return Self { f0, base: None, facet_probability: 1.0 };
        }
        let albedo = Row::of(distribution);
        let from_here = albedo.directional(cos_o);
        let through = (1.0 - metallic) * (1.0 - from_here.at(COAT_F0));
        let (by_facets, by_base) = (from_here.at(f0.mean()), through * base_colour.mean());
        let seen = base_colour * (FRAC_1_PI * through / (1.0 - albedo.mean().at(COAT_F0)));
        Self { f0, base: Some(Base { seen, coat: albedo }), facet_probability: by_facets / (by_facets + by_base) }
    }

    #[inline]
    fn fresnel(&self, cos_facet: f32) -> SampledSpectrum {
        let white = schlick_weight(cos_facet);
        self.f0 * (1.0 - white) + SampledSpectrum::splat(white)
    }

    /// Facets and base together; for a smooth surface the base alone.
    #[inline]
    fn both(&self, kernel: Option<ReflectionKernel>, cos_i: f32) -> BsdfEval {
        let mut f = SampledSpectrum::ZERO;
        let mut pdf = 0.0;
        if let Some(Base { seen, coat }) = &self.base {
            f = *seen * (1.0 - coat.directional(cos_i).at(COAT_F0));
            pdf = (1.0 - self.facet_probability) * cos_i * FRAC_1_PI;
        }
        if let Some(kernel) = kernel {
            f += self.fresnel(kernel.cos_facet) * kernel.value;
            pdf += self.facet_probability * kernel.pdf;
        }
        BsdfEval { f, pdf: Pdf::new(pdf) }
    }
}

#[inline]
pub(super) fn is_delta(metallic: f32, distribution: Ggx) -> bool {
    distribution.is_smooth() && metallic >= 1.0
}

#[inline]
pub(super) fn eval(base_colour: SampledSpectrum, metallic: f32, distribution: Ggx, wo: Vec3, wi: Vec3) -> BsdfEval {
    if !(is_above(wo) && is_above(wi)) || is_delta(metallic, distribution) {
        return BsdfEval::ZERO;
    }
    let kernel = (!distribution.is_smooth()).then(|| distribution.reflection(wo, wi));
    Seen::new(base_colour, metallic, distribution, wo.z).both(kernel, wi.z)
}

#[inline]
pub(super) fn sample(
    base_colour: SampledSpectrum,
    metallic: f32,
    distribution: Ggx,
    wo: Vec3,
    u_lobe: f32,
    u: [f32; 2],
) -> Option<BsdfSample> {
    if !is_above(wo) {
        return None;
    }
    let seen = Seen::new(base_colour, metallic, distribution, wo.z);
    let (wi, kernel) = if u_lobe >= seen.facet_probability {
        let wi = warp::cosine_hemisphere(u);
        if !is_above(wi) {
            return None;
        }
        (wi, (!distribution.is_smooth()).then(|| distribution.reflection(wo, wi)))
    } else if distribution.is_smooth() {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        return Some(BsdfSample::mirrored(seen.fresnel(wo.z.min(1.0)), wi, seen.facet_probability));
    } else {
        let (wi, kernel) = distribution.sample_reflection(wo, u)?;
        (wi, Some(kernel))
    };
    let BsdfEval { f, pdf } = seen.both(kernel, wi.z);
    (pdf.0 > 0.0).then(|| BsdfSample::reflected(f, wi, pdf))
}
