//! Metals: GGX facets, each a mirror with the exact Fresnel reflectance of the complex index η + i·k.
//!
//! f = F(wo·m)·D(m)·G₂(wo, wi)/(4·cos θₒ·cos θᵢ) with m the half vector
//! ([Walter07](photosite_core::references#walter07) eq. 20), for wo and wi above the surface. Polished, it is a mirror.
//!
//! Light that bounces more than once between facets is lost: the model reflects too little where α comes near 1. With
//! energy compensation it comes back, spread over what one bounce leaves (`compensation`).

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::albedo::Row;
use super::compensation::{NOTHING_LEFT, further_bounces};
use super::directions::is_above;
use super::form::{Form, Map, Sampled, TableForm};
use super::fresnel;
use super::lobe::{Lobe, SceneTraits, Traits};
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::math::{Pdf, warp};
use photosite_core::spectrum::SampledSpectrum;

/// A metal.
#[derive(Clone, Copy, Debug)]
pub struct Conductor<F: Form = Sampled> {
    /// Real part of the refractive index, relative to the medium outside.
    pub eta: F::Spectrum,
    /// Imaginary part (extinction coefficient), relative to the medium outside.
    pub k: F::Spectrum,
    /// Roughness of its microfacets.
    pub distribution: F::Distribution,
    /// Whether the model includes light that bounces more than once between facets.
    pub energy_compensation: bool,
}

impl<F: Form> Conductor<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> Conductor<T> {
        let (eta, k) = (map.spectrum(&self.eta), map.spectrum(&self.k));
        let distribution = map.distribution(&self.distribution);
        Conductor { eta, k, distribution, energy_compensation: self.energy_compensation }
    }
}

impl<F: TableForm> SceneTraits for Conductor<F> {
    fn may_cast_caustics(&self) -> bool {
        self.distribution.is_near_specular()
    }
}

/// Light that bounces more than once between facets, seen from one direction.
struct Bounces {
    row: Row,
    /// Value f over R(wi).
    value: SampledSpectrum,
    /// Probability of the facets' lobe, by what either gives back.
    facets: f32,
}

impl Bounces {
    /// Value and density of both lobes together, where the facets' own are `f` and `pdf`.
    #[inline]
    fn with(&self, wi: Vec3, f: SampledSpectrum, pdf: f32) -> BsdfEval {
        let left = (1.0 - self.row.directional(wi).at(1.0)).max(0.0);
        let pdf = self.facets * pdf + (1.0 - self.facets) * wi.z * FRAC_1_PI;
        BsdfEval { f: f + self.value * left, pdf: Pdf::new(pdf) }
    }
}

impl Conductor {
    /// Part of the light from all directions that bounces more than once between facets before it leaves the metal.
    pub fn multiple_scattering(&self) -> SampledSpectrum {
        let mean = Row::of(self.distribution).mean().at(1.0);
        further_bounces(1.0 - mean, fresnel::mean_conductor(self.eta, self.k), mean)
    }

    #[inline]
    fn bounces(&self, wo: Vec3) -> Option<Bounces> {
        if !self.energy_compensation {
            return None;
        }
        let row = Row::of(self.distribution);
        let (mean, seen) = (row.mean().at(1.0), row.directional(wo).at(1.0));
        let left = (1.0 - seen).max(0.0);
        (1.0 - mean > NOTHING_LEFT).then(|| {
            let reflectance = fresnel::mean_conductor(self.eta, self.k);
            let given = further_bounces(1.0, reflectance, mean);
            let [once, further] = [reflectance.mean() * seen, given.mean() * left];
            let facets = once / (once + further).max(f32::MIN_POSITIVE);
            Bounces { row, value: given * (FRAC_1_PI * left / (1.0 - mean)), facets }
        })
    }
}

impl Lobe for Conductor {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        if self.distribution.is_smooth() || !(is_above(wo) && is_above(wi)) {
            return BsdfEval::ZERO;
        }
        let kernel = self.distribution.reflection(wo, wi);
        let f = fresnel::conductor(kernel.cos_facet, self.eta, self.k) * kernel.value;
        match self.bounces(wo) {
            Some(bounces) => bounces.with(wi, f, kernel.pdf),
            None => BsdfEval { f, pdf: Pdf::new(kernel.pdf) },
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !is_above(wo) {
            return None;
        }
        if self.distribution.is_smooth() {
            let wi = Vec3::new(-wo.x, -wo.y, wo.z);
            return Some(BsdfSample::mirrored(fresnel::conductor(wo.z.min(1.0), self.eta, self.k), wi, 1.0));
        }
        if let Some(bounces) = self.bounces(wo) {
            let is_facet = u_lobe < bounces.facets;
            let wi = if is_facet {
                self.distribution.sample_reflection(wo, u)?.0
            } else {
                warp::cosine_hemisphere(u).into()
            };
            let BsdfEval { f, pdf } = self.eval(wo, wi);
            return (pdf.0 > 0.0).then(|| BsdfSample::reflected(f, wi, pdf));
        }
        let (wi, kernel) = self.distribution.sample_reflection(wo, u)?;
        let f = fresnel::conductor(kernel.cos_facet, self.eta, self.k) * kernel.value;
        Some(BsdfSample::reflected(f, wi, Pdf::new(kernel.pdf)))
    }

    #[inline]
    fn traits(&self) -> Traits {
        Traits {
            has_lobes: self.energy_compensation && !self.distribution.is_smooth(),
            is_delta: self.distribution.is_smooth(),
            casts_caustics: self.distribution.is_near_specular(),
            ..Traits::default()
        }
    }
}
