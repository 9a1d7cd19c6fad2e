//! Refraction by GGX facets and by smooth interfaces, for all models that refract; the equations are in
//! [`dielectric`](super::dielectric).

use glam::Vec3;

use super::directions::GRAZING;
use super::fresnel::{self, Interface};
use super::microfacet::{self, Ggx};
use photosite_core::spectrum::SampledSpectrum;

/// Smallest angular blur of refracted light, rad, below which an interface counts as smooth. The half vector of
/// refraction is as uncertain as 6e-8/|η − 1|, so it must stay well below α. Takes in η = 1: no interface at all.
const SMALLEST_BLUR: f32 = 2e-6;

/// Whether the interface sends light into two directions only.
#[inline]
pub(super) fn is_delta(eta: SampledSpectrum, distribution: Ggx) -> bool {
    distribution.is_smooth() || distribution.widest() * (eta[0] - 1.0).abs() < SMALLEST_BLUR
}

/// Spectrum of `value` for the hero, and for the other lanes unless the direction depends on wavelength.
#[inline]
pub(super) fn lanes(value: f32, dispersive: bool) -> SampledSpectrum {
    if dispersive { SampledSpectrum::from([value, 0.0, 0.0, 0.0]) } else { SampledSpectrum::splat(value) }
}

/// A facet that refracts `wo` into `wi`.
pub(super) struct Refraction {
    /// Relative refractive index: n on the side of wi over n on the side of wo.
    pub(super) eta: f32,
    /// The facet's normal, on the side of wo.
    pub(super) m: Vec3,
    /// Cosine wo·m.
    pub(super) cos_o: f32,
    /// Cosine −wi·m.
    pub(super) cos_i: f32,
    /// |wo + η·wi| = |wo·m + η·wi·m|.
    pub(super) stretch: f32,
    /// Transmittance 1 − F.
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

    /// Refraction of `wo` by the facet of normal `m`: the facet and `wi`. None where it would not lie below the
    /// surface. The transmittance is left at 1.
    #[inline]
    pub(super) fn by(eta: f32, wo: Vec3, m: Vec3, cos_o: f32, cos_transmitted: f32) -> Option<(Self, Vec3)> {
        let wi = (cos_o / eta - cos_transmitted) * m - wo / eta;
        let stretch = (cos_o - eta * cos_transmitted).abs();
        let facet = Self { eta, m, cos_o, cos_i: cos_transmitted, stretch, transmittance: 1.0 };
        // A facet seen edge-on has no side that it refracts to.
        (cos_o > 0.0 && cos_transmitted > 0.0 && wi.z < -GRAZING).then_some((facet, wi))
    }
}

/// Power from one direction that one facet reflects and refracts.
pub(super) struct Bounce {
    /// The part that leaves where the facet reflects all, and where it refracts all.
    pub(super) reflected: f32,
    pub(super) refracted: f32,
    /// Reflection and transmission at the facet, and the cosine of the angle of incidence (`cos_o`).
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
/// ([Walter07](photosite_core::references#walter07) eq. 17). No cosine to the surface is divided by: see
/// [`microfacet`].
#[inline]
pub(super) fn refraction(distribution: Ggx, wo: Vec3, wi: Vec3, facet: &Refraction) -> (f32, f32) {
    let &Refraction { eta, m, cos_o, cos_i, stretch, transmittance } = facet;
    let seen = wo.z + distribution.stretched_length(wo);
    let lit = -wi.z + distribution.stretched_length(wi);
    let common = 2.0 * transmittance * distribution.density(m) * cos_o * cos_i / (seen * stretch * stretch);
    (common * 2.0 / lit, common * eta * eta)
}
