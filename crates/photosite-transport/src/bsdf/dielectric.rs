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
//! This is the f of radiance: light that enters a denser medium is compressed into a smaller cone, L/n² passes a
//! lossless interface unchanged, and reciprocity reads η²·f(wo, wi) = f(wi, wo)
//! ([Veach97](photosite_core::references#veach97) §5.2).
//!
//! Smith's model lets a facet at height h (C the part of the surface below it) be seen with probability C^Λ(w) from
//! above and (1 − C)^Λ(w) from below. The mean over all heights is 1/(1 + Λₒ + Λᵢ) where both directions are above, the
//! height-correlated G₂ of reflection. In refraction it is the Beta function B(1 + Λₒ, 1 + Λᵢ): what is easily seen
//! from one side is hidden from the other. No cheap form of it is known; G₁(wo)·G₁(wi), which is used here as in
//! [Walter07](photosite_core::references#walter07), lies between it and the height-correlated one.
//!
//! Light that bounces more than once between facets is lost. With energy compensation it goes on, spread on both sides
//! over what one bounce leaves (`compensation`).
//!
//! Where the index depends on wavelength so does the direction of refraction: it is right for the hero alone. A smooth
//! surface keeps all wavelengths in reflection, since the direction is common to them; a rough one asks the path to go
//! on with the hero alone ([`super::Bsdf::needs_single_wavelength`]).

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::albedo::GlassRow;
use super::compensation::{Shared, shared_out};
use super::directions::{GRAZING, is_grazing, mirrored};
use super::form::{Form, Map, RelativeIndex, Sampled, TableForm};
use super::fresnel::{self, Interface};
use super::lobe::{Lobe, SceneTraits, Traits};
use super::microfacet::{self, Ggx};
use super::refraction::{Refraction, is_delta, lanes, refraction};
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::math::{Pdf, warp};
use photosite_core::spectrum::SampledSpectrum;

/// The index of the far side over that of the side of `wo`, and `z` mirrored if need be so that `wo` is above.
#[inline]
fn seen_from_above(eta: f32, wo: Vec3) -> (f32, Vec3) {
    if wo.z < 0.0 { (1.0 / eta, mirrored(wo)) } else { (eta, wo) }
}

/// A clear medium on the side that the normal points away from.
#[derive(Clone, Copy, Debug)]
pub struct Dielectric<F: Form = Sampled> {
    /// Relative refractive index n_inside/n_outside.
    pub index: F::Index,
    /// Roughness of its microfacets.
    pub distribution: F::Distribution,
    /// Whether the model includes light that bounces more than once between facets.
    pub energy_compensation: bool,
}

impl<F: Form> Dielectric<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> Dielectric<T> {
        let (index, distribution) = (map.index(&self.index), map.distribution(&self.distribution));
        Dielectric { index, distribution, energy_compensation: self.energy_compensation }
    }
}

impl<F: TableForm> SceneTraits for Dielectric<F> {
    fn disperses(&self) -> bool {
        self.index.dispersive
    }

    fn may_pass_straight(&self) -> bool {
        self.index.is_one
    }

    fn may_cast_caustics(&self) -> bool {
        true
    }
}

impl Lobe for Dielectric {
    const REFRACTS: bool = true;

    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let &Self { index: RelativeIndex { eta, dispersive, .. }, distribution, .. } = self;
        if is_delta(eta, distribution) || is_grazing(wo) || is_grazing(wi) {
            return BsdfEval::ZERO;
        }
        let wi = if wo.z < 0.0 { mirrored(wi) } else { wi };
        let (eta, wo) = seen_from_above(eta[0], wo);
        let facets = eval_rough(eta, distribution, wo, wi);
        let (f, pdf) = self.bounces(eta, wo).map_or(facets, |bounces| bounces.with(wi, facets));
        BsdfEval { f: lanes(f, dispersive), pdf: Pdf::new(pdf) }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let &Self { index: RelativeIndex { eta, dispersive, .. }, distribution, .. } = self;
        if is_grazing(wo) {
            return None;
        }
        let below = wo.z < 0.0;
        let sample = if is_delta(eta, distribution) {
            let (eta, wo) = if below { (SampledSpectrum::ONE / eta, mirrored(wo)) } else { (eta, wo) };
            sample_smooth(eta, dispersive, wo, u_lobe)
        } else {
            let (eta, wo) = seen_from_above(eta[0], wo);
            match self.bounces(eta, wo) {
                Some(bounces) => bounces.sample(self, eta, wo, u_lobe, u),
                None => sample_rough(eta, dispersive, distribution, wo, u_lobe, u),
            }
        };
        sample.map(|sample| if below { BsdfSample { wi: mirrored(sample.wi), ..sample } } else { sample })
    }

    #[inline]
    fn straight(&self, wo: Vec3) -> SampledSpectrum {
        if self.index.is_one && !is_grazing(wo) { SampledSpectrum::ONE } else { SampledSpectrum::ZERO }
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

/// Light that bounces more than once between facets, seen from `wo`, above them.
struct Bounces {
    row: GlassRow,
    shared: Shared,
    /// Light R(wo) that one bounce leaves.
    left: f32,
}

impl Dielectric {
    /// Part of the light from all directions on the side of the normal that bounces more than once between the facets.
    pub fn multiple_scattering(&self) -> f32 {
        (1.0 - GlassRow::of(self.index.eta[0], self.distribution).mean()[0]).max(0.0)
    }

    #[inline]
    fn bounces(&self, eta: f32, wo: Vec3) -> Option<Bounces> {
        if !self.energy_compensation {
            return None;
        }
        let row = GlassRow::of(eta, self.distribution);
        let shared = shared_out(1.0, eta, row.mean().map(|once| 1.0 - once))?;
        let left = (1.0 - row.directional(wo)[0]).max(0.0);
        Some(Bounces { row, shared, left })
    }
}

impl Bounces {
    /// Value and density of both lobes together, of which the facets' own are given.
    #[inline]
    fn with(&self, wi: Vec3, (f, pdf): (f32, f32)) -> (f32, f32) {
        let Self { row, shared: Shared { scales, crossing }, left } = self;
        let cos = wi.z.abs();
        let side = usize::from(wi.z < 0.0);
        let other = (1.0 - row.directional(Vec3::new(wi.x, wi.y, cos))[side]).max(0.0);
        let share = if side == 0 { 1.0 - crossing } else { *crossing };
        (f + scales[side] * left * other, (1.0 - left) * pdf + left * share * cos * FRAC_1_PI)
    }

    /// Samples either lobe in proportion to the light that it gives back.
    #[inline]
    fn sample(&self, glass: &Dielectric, eta: f32, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let &Dielectric { index: RelativeIndex { dispersive, .. }, distribution, .. } = glass;
        let facets = 1.0 - self.left;
        let wi = if u_lobe < facets {
            sample_rough(eta, dispersive, distribution, wo, u_lobe / facets, u)?.wi
        } else {
            let spread = Vec3::from(warp::cosine_hemisphere(u));
            if u_lobe - facets < self.left * self.shared.crossing { mirrored(spread) } else { spread }
        };
        let (f, pdf) = self.with(wi, eval_rough(eta, distribution, wo, wi));
        let sample = BsdfSample::reflected(lanes(f, dispersive), wi, Pdf::new(pdf));
        let is_transmission = wi.z < 0.0;
        let eta = if is_transmission { eta } else { 1.0 };
        (pdf > 0.0 && !is_grazing(wi)).then_some(BsdfSample {
            is_transmission,
            terminates_secondary: dispersive,
            eta,
            ..sample
        })
    }
}

/// Value and density of one bounce at facets, `wo` above them.
#[inline]
fn eval_rough(eta: f32, distribution: Ggx, wo: Vec3, wi: Vec3) -> (f32, f32) {
    if wi.z > 0.0 {
        let kernel = distribution.reflection(wo, wi);
        let reflectance = fresnel::dielectric(kernel.cos_facet, eta).reflectance;
        return (kernel.value * reflectance, kernel.pdf * reflectance);
    }
    let Some(facet) = Refraction::between(eta, wo, wi) else { return (0.0, 0.0) };
    let transmittance = fresnel::between(facet.cos_o.min(1.0), facet.cos_i.min(1.0), eta).transmittance;
    refraction(distribution, wo, wi, &Refraction { transmittance, ..facet })
}

/// Samples a smooth interface, with `wo` above it: reflection with the hero's probability R, refraction with 1 − R.
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
