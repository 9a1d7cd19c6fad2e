//! Clear media: glass, water, plastic without pigment. GGX facets that reflect a part F of the light and refract the
//! rest, or one smooth interface.
//!
//! The inside is the side that +Z points away from; `eta` = n_inside/n_outside. `wo` may come from either side. With η
//! the index on the side of `wi` over that on the side of `wo`, and cosines taken positive
//! ([Walter07](photosite_core::references#walter07) eqs. 20 and 21):
//!
//! - reflection: f = F·D·G₂/(4·cos θₒ·cos θᵢ), m ∝ wo + wi;
//! - refraction: f = (1 − F)·D·G₂·|wo·m|·|wi·m|/(cos θₒ·cos θᵢ·(wo·m + η·wi·m)²), m ∝ ±(wo + η·wi).
//!
//! This is the f of radiance: light that enters a denser medium is compressed into a smaller cone, L/n² passes a lossless
//! interface unchanged, and reciprocity reads η²·f(wo, wi) = f(wi, wo) ([Veach97](photosite_core::references#veach97) §5.2).
//!
//! Smith's model lets a facet at height h (C the part of the surface below it) be seen with probability C^Λ(w) from above
//! and (1 − C)^Λ(w) from below. The mean over all heights is 1/(1 + Λₒ + Λᵢ) where both directions are above, the
//! height-correlated G₂ of reflection. In refraction it is the Beta function B(1 + Λₒ, 1 + Λᵢ): what is easily seen from
//! one side is hidden from the other. No cheap form of it is known; G₁(wo)·G₁(wi), which is used here as in
//! [Walter07](photosite_core::references#walter07), lies between it and the height-correlated one.
//!
//! Where the index depends on wavelength so does the direction of refraction: it is right for the hero alone. A smooth
//! surface keeps all wavelengths in reflection, since the direction is common to them; a rough one asks the path to go
//! on with the hero alone ([`super::Bsdf::needs_single_wavelength`]).

use glam::Vec3;

use super::fresnel::{self, Interface};
use super::microfacet::{self, Ggx};
use super::model::{Form, Lobe, Map, RelativeIndex, Sampled, SceneTraits, TableForm, Traits};
use super::{BsdfEval, BsdfSample, GRAZING, is_grazing};
use photosite_core::math::Pdf;
use photosite_core::spectrum::SampledSpectrum;

/// Below this angular blur of refracted light, rad, an interface counts as smooth. The half vector of refraction is as
/// uncertain as 6e-8/|η − 1|, so it must stay well below α. Takes in η = 1: no interface at all.
const SMALLEST_BLUR: f32 = 2e-6;

/// Whether the interface sends light into two directions only.
#[inline]
pub(super) fn is_delta(eta: SampledSpectrum, distribution: Ggx) -> bool {
    distribution.is_smooth() || distribution.widest() * (eta[0] - 1.0).abs() < SMALLEST_BLUR
}

/// The index of the far side over that of the side of `wo`, and `z` mirrored if need be so that `wo` is above.
#[inline]
fn seen_from_above(eta: f32, wo: Vec3) -> (f32, Vec3) {
    if wo.z < 0.0 { (1.0 / eta, mirrored(wo)) } else { (eta, wo) }
}

#[inline]
pub(super) fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

/// `value` for the hero, and for the other lanes unless the direction depends on wavelength.
#[inline]
pub(super) fn lanes(value: f32, dispersive: bool) -> SampledSpectrum {
    if dispersive { SampledSpectrum::from([value, 0.0, 0.0, 0.0]) } else { SampledSpectrum::splat(value) }
}

/// A clear medium on the side that the normal points away from.
#[derive(Clone, Copy, Debug)]
pub struct Dielectric<F: Form = Sampled> {
    /// n_inside/n_outside.
    pub index: F::Index,
    /// Roughness of its microfacets.
    pub distribution: F::Distribution,
}

impl<F: Form> Dielectric<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> Dielectric<T> {
        Dielectric { index: map.index(&self.index), distribution: map.distribution(&self.distribution) }
    }
}

impl<F: TableForm> SceneTraits for Dielectric<F> {
    fn disperses(&self) -> bool {
        self.index.dispersive
    }

    fn may_cast_caustics(&self) -> bool {
        true
    }
}

impl Lobe for Dielectric {
    const REFRACTS: bool = true;

    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let &Self { index: RelativeIndex { eta, dispersive }, distribution } = self;
        if is_delta(eta, distribution) || is_grazing(wo) || is_grazing(wi) {
            return BsdfEval::ZERO;
        }
        let wi = if wo.z < 0.0 { mirrored(wi) } else { wi };
        let (eta, wo) = seen_from_above(eta[0], wo);
        let (f, pdf) = if wi.z > 0.0 {
            let kernel = distribution.reflection(wo, wi);
            let reflectance = fresnel::dielectric(kernel.cos_facet, eta).reflectance;
            (kernel.value * reflectance, kernel.pdf * reflectance)
        } else {
            let Some(facet) = Refraction::between(eta, wo, wi) else { return BsdfEval::ZERO };
            let transmittance = fresnel::between(facet.cos_o.min(1.0), facet.cos_i.min(1.0), eta).transmittance;
            refraction(distribution, wo, wi, &Refraction { transmittance, ..facet })
        };
        BsdfEval { f: lanes(f, dispersive), pdf: Pdf::new(pdf) }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let &Self { index: RelativeIndex { eta, dispersive }, distribution } = self;
        if is_grazing(wo) {
            return None;
        }
        let below = wo.z < 0.0;
        let sample = if is_delta(eta, distribution) {
            let (eta, wo) = if below { (SampledSpectrum::ONE / eta, mirrored(wo)) } else { (eta, wo) };
            sample_smooth(eta, dispersive, wo, u_lobe)
        } else {
            let (eta, wo) = seen_from_above(eta[0], wo);
            sample_rough(eta, dispersive, distribution, wo, u_lobe, u)
        };
        sample.map(|sample| if below { BsdfSample { wi: mirrored(sample.wi), ..sample } } else { sample })
    }

    #[inline]
    fn traits(&self) -> Traits {
        let is_delta = is_delta(self.index.eta, self.distribution);
        Traits {
            has_lobes: true,
            transmits: true,
            is_delta,
            casts_caustics: self.distribution.is_near_specular() || is_delta,
            needs_single_wavelength: self.index.dispersive && !is_delta,
        }
    }
}

/// One interface, `wo` above it: reflection with the hero's probability R, refraction with 1 − R.
#[inline]
fn sample_smooth(eta: SampledSpectrum, dispersive: bool, wo: Vec3, u_lobe: f32) -> Option<BsdfSample> {
    let cos_o = wo.z.min(1.0);
    let Interface { reflectance, transmittance, cos_transmitted } = fresnel::dielectric(cos_o, eta[0]);
    if u_lobe < reflectance {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        let of_lanes = if dispersive {
            eta.map(|eta| fresnel::dielectric(cos_o, eta).reflectance)
        } else {
            SampledSpectrum::splat(reflectance)
        };
        return Some(BsdfSample::mirrored(of_lanes, wi, reflectance));
    }
    if cos_transmitted <= GRAZING {
        return None;
    }
    let eta = eta[0];
    Some(BsdfSample {
        f: lanes(transmittance / (eta * eta * cos_transmitted), dispersive),
        wi: Vec3::new(-wo.x / eta, -wo.y / eta, -cos_transmitted),
        pdf: Pdf::new(transmittance),
        is_delta: true,
        is_transmission: true,
        terminates_secondary: dispersive,
        eta,
    })
}

/// Facets, `wo` above them: a visible one is drawn, then reflection or refraction by its reflectance.
#[inline]
fn sample_rough(
    eta: f32,
    dispersive: bool,
    distribution: Ggx,
    wo: Vec3,
    u_lobe: f32,
    u: [f32; 2],
) -> Option<BsdfSample> {
    let m = distribution.sample_visible(wo, u);
    let cos_o = wo.dot(m).clamp(0.0, 1.0);
    let Interface { reflectance, transmittance, cos_transmitted } = fresnel::dielectric(cos_o, eta);
    if u_lobe < reflectance {
        let wi = microfacet::reflect(wo, m);
        if wi.z <= GRAZING {
            return None;
        }
        let kernel = distribution.reflection_at(wo, wi, m);
        let f = lanes(kernel.value * reflectance, dispersive);
        let sample = BsdfSample::reflected(f, wi, Pdf::new(kernel.pdf * reflectance));
        return Some(BsdfSample { terminates_secondary: dispersive, ..sample });
    }
    let (facet, wi) = Refraction::by(eta, wo, m, cos_o, cos_transmitted)?;
    let (f, pdf) = refraction(distribution, wo, wi, &Refraction { transmittance, ..facet });
    (pdf > 0.0).then(|| BsdfSample {
        f: lanes(f, dispersive),
        wi,
        pdf: Pdf::new(pdf),
        is_delta: false,
        is_transmission: true,
        terminates_secondary: dispersive,
        eta,
    })
}

/// A facet that refracts `wo` into `wi`.
pub(super) struct Refraction {
    /// n on the side of wi over n on the side of wo.
    pub(super) eta: f32,
    /// The facet's normal, on the side of wo.
    pub(super) m: Vec3,
    /// wo·m.
    pub(super) cos_o: f32,
    /// −wi·m.
    pub(super) cos_i: f32,
    /// |wo + η·wi| = |wo·m + η·wi·m|.
    pub(super) stretch: f32,
    /// 1 − F.
    pub(super) transmittance: f32,
}

impl Refraction {
    /// The facet that refracts `wo`, above it, into `wi`, below it. None where facets show either direction their back,
    /// and for the undefined facet of a vanishing sum. The transmittance is left at 1.
    #[inline]
    pub(super) fn between(eta: f32, wo: Vec3, wi: Vec3) -> Option<Self> {
        let sum = wo + eta * wi;
        let stretch = sum.length();
        let m = sum / stretch.copysign(sum.z);
        let (cos_o, cos_i) = (wo.dot(m), -wi.dot(m));
        (cos_o > 0.0 && cos_i > 0.0).then_some(Self { eta, m, cos_o, cos_i, stretch, transmittance: 1.0 })
    }

    /// Refraction of `wo` by the facet of normal `m`: the facet and `wi`. None where it would not lie below the surface.
    /// The transmittance is left at 1.
    #[inline]
    pub(super) fn by(eta: f32, wo: Vec3, m: Vec3, cos_o: f32, cos_transmitted: f32) -> Option<(Self, Vec3)> {
        let wi = (cos_o / eta - cos_transmitted) * m - wo / eta;
        let stretch = (cos_o - eta * cos_transmitted).abs();
        let facet = Self { eta, m, cos_o, cos_i: cos_transmitted, stretch, transmittance: 1.0 };
        // A facet seen edge-on has no side that it refracts to.
        (cos_o > 0.0 && cos_transmitted > 0.0 && wi.z < -GRAZING).then_some((facet, wi))
    }
}

/// What becomes of the power from one direction at one facet.
pub(super) struct Bounce {
    /// The part that leaves where the facet reflects all, and where it refracts all.
    pub(super) reflected: f32,
    pub(super) refracted: f32,
    /// What the facet does, and the cosine that it is met at.
    pub(super) interface: Interface,
    pub(super) cos_o: f32,
}

impl Bounce {
    /// The part that leaves.
    pub(super) fn power(&self) -> f32 {
        self.interface.reflectance * self.reflected + self.interface.transmittance * self.refracted
    }
}

/// Light from `wo`, above the surface, at the facet drawn by `u`.
pub(super) fn bounce(eta: f32, distribution: Ggx, wo: Vec3, u: [f32; 2]) -> Bounce {
    let m = distribution.sample_visible(wo, u);
    let cos_o = wo.dot(m).clamp(0.0, 1.0);
    let interface = fresnel::dielectric(cos_o, eta);
    let mut bounce = Bounce { reflected: 0.0, refracted: 0.0, interface, cos_o };
    let wi = microfacet::reflect(wo, m);
    if wi.z > GRAZING {
        let kernel = distribution.reflection_at(wo, wi, m);
        bounce.reflected = kernel.value * wi.z / kernel.pdf;
    }
    if let Some((facet, wi)) = Refraction::by(eta, wo, m, cos_o, bounce.interface.cos_transmitted) {
        let (f, pdf) = refraction(distribution, wo, wi, &facet);
        // Where facets are seen edge-on both vanish.
        if pdf > 0.0 {
            bounce.refracted = eta * eta * f * -wi.z / pdf;
        }
    }
    bounce
}

/// Value and density of refraction, with dm/dwi = η²·|wi·m|/(wo·m + η·wi·m)²
/// ([Walter07](photosite_core::references#walter07) eq. 17). No cosine to the surface is divided by: see [`microfacet`].
#[inline]
pub(super) fn refraction(distribution: Ggx, wo: Vec3, wi: Vec3, facet: &Refraction) -> (f32, f32) {
    let &Refraction { eta, m, cos_o, cos_i, stretch, transmittance } = facet;
    let seen = wo.z + distribution.stretched_length(wo);
    let lit = -wi.z + distribution.stretched_length(wi);
    let common = 2.0 * transmittance * distribution.density(m) * cos_o * cos_i / (seen * stretch * stretch);
    (common * 2.0 / lit, common * eta * eta)
}
