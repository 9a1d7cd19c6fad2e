//! Retroreflective sheeting: road signs, safety clothing, markers of motion capture. Prisms below a clear surface, each
//! the corner of a cube, send light back to where it comes from.
//!
//! **The lobe** is that of GGX microfacets which see the mirror image w' = (−x, −y, z) of `wo` in its place
//! ([Portsmouth26](photosite_core::references#portsmouth26); the half vector of w' and wi is the back vector b of
//! [Belcour14](photosite_core::references#belcour14)):
//!
//! f_r = R·min(a(θₒ), a(θᵢ))·D(b)·G₂(w', wi)/(4·cos θₒ·cos θᵢ), b ∝ w' + wi.
//!
//! It has its peak at wi = wo and falls as D does at half the observation angle, the angle between both. D is the same
//! after half a turn about the normal, so that f_r is reciprocal and has the albedo of the microfacets, R·a(θₒ) at
//! most.
//!
//! **The active part** of the sheeting is what light enters a corner by and leaves it by too. Light refracted to the
//! angle θ', sin θ' = sin θ/n, leaves a corner with a circular opening where the point reflection of its entry through
//! the tip lies. Both openings overlap, tan θ' below 1/√2, by
//!
//! a(θ) = 2/π·(arccos s − s·√(1 − s²)), s = √2·tan θ' ([Degnan93](photosite_core::references#degnan93)).
//!
//! R is the part of the light along the normal that returns; whatever is lost at the surface and in the corners is in
//! it.
//!
//! **What does not return** is scattered by Lambert's law in the form that is reciprocal and loses nothing: with
//! e(θ) = R·a(θ) and ē its mean over the hemisphere, f_d = ρ/π·(1 − e(θₒ))(1 − e(θᵢ))/(1 − ē). The albedo is at most
//! e + ρ·(1 − e). The gloss of the surface is left to a mix.

use std::f32::consts::{FRAC_1_PI, FRAC_2_PI};

use glam::Vec3;

use super::directions::is_above;
use super::form::{Form, Map, Sampled, TableForm};
use super::lobe::{Lobe, SceneTraits, Traits};
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::math::{Pdf, warp};
use photosite_core::spectrum::SampledSpectrum;

/// Retroreflective sheeting.
#[derive(Clone, Copy, Debug)]
pub struct Retroreflective<F: Form = Sampled> {
    /// Retroreflectance R, the part of the light along the normal that returns, 0–1.
    pub retroreflectance: F::Colour,
    /// Reflectance ρ, the part of all other light that is scattered by Lambert's law, 0–1.
    pub reflectance: F::Colour,
    /// Prisms that send light back.
    pub corners: CubeCorners,
    /// Width of the lobe about the direction back, as roughness of microfacets.
    pub distribution: F::Distribution,
}

impl<F: Form> Retroreflective<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> Retroreflective<T> {
        Retroreflective {
            retroreflectance: map.colour(&self.retroreflectance),
            reflectance: map.colour(&self.reflectance),
            corners: self.corners,
            distribution: map.distribution(&self.distribution),
        }
    }
}

impl<F: TableForm> SceneTraits for Retroreflective<F> {
    fn may_cast_caustics(&self) -> bool {
        self.distribution.is_near_specular()
    }
}

/// Cube corners with circular openings, side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeCorners {
    index: f32,
    /// Mean active part ∫ 2μ·a(μ) dμ.
    mean: f32,
}

impl CubeCorners {
    /// Returns corners of a refractive index of at least 1.
    pub fn new(index: f32) -> Self {
        // The midpoint rule; a is smooth but for its end, where it is as flat as a power of 3/2: some 1e-6.
        const STEPS: usize = 1000;
        let corners = Self { index: index.max(1.0), mean: 0.0 };
        let at = |i: usize| (i as f32 + 0.5) / STEPS as f32;
        let sum: f64 = (0..STEPS).map(|i| f64::from(2.0 * at(i) * corners.active_part(at(i)))).sum();
        Self { mean: (sum / STEPS as f64) as f32, ..corners }
    }

    /// Index, and mean active part.
    pub fn numbers(&self) -> [f32; 2] {
        [self.index, self.mean]
    }

    /// Active part a, the part of the light at the cosine `cos` to the normal that enters a corner and leaves it, 0–1.
    #[inline]
    pub fn active_part(&self, cos: f32) -> f32 {
        let sin_squared = (1.0 - cos * cos).max(0.0);
        // s² = 2·tan² θ'. Along the surface of an index of 1 it is infinite.
        let squared = 2.0 * sin_squared / (self.index * self.index - sin_squared);
        if !(0.0..1.0).contains(&squared) {
            return 0.0;
        }
        let (s, other) = (squared.sqrt(), (1.0 - squared).sqrt());
        (FRAC_2_PI * (other.atan2(s) - s * other)).max(0.0)
    }
}

impl Retroreflective {
    /// Active part a of light from `wo`, and the part of the samples that go back; `None` where all is black.
    #[inline]
    fn parts(&self, wo: Vec3) -> Option<(f32, f32)> {
        let active = self.corners.active_part(wo.z);
        let returned = self.retroreflectance * active;
        let [lobe, diffuse] = [returned.mean(), (self.reflectance * (SampledSpectrum::ONE - returned)).mean()];
        let sum = lobe + diffuse;
        (sum > 0.0).then(|| (active, lobe / sum))
    }
}

impl Lobe for Retroreflective {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let Some((active, lobe)) = self.parts(wo).filter(|_| is_above(wo) && is_above(wi)) else {
            return BsdfEval::ZERO;
        };
        let active_i = self.corners.active_part(wi.z);
        let left = |active: f32| SampledSpectrum::ONE - self.retroreflectance * active;
        let mut f = self.reflectance * left(active) * left(active_i) / left(self.corners.mean) * FRAC_1_PI;
        let mut pdf = (1.0 - lobe) * wi.z * FRAC_1_PI;
        if !self.distribution.is_smooth() {
            let kernel = self.distribution.reflection(mirrored(wo), wi);
            f += self.retroreflectance * (active.min(active_i) * kernel.value);
            pdf += lobe * kernel.pdf;
        }
        if pdf > 0.0 { BsdfEval { f, pdf: Pdf::new(pdf) } } else { BsdfEval::ZERO }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !is_above(wo) {
            return None;
        }
        let (active, lobe) = self.parts(wo)?;
        let wi = if u_lobe >= lobe {
            warp::cosine_hemisphere(u).into()
        } else if self.distribution.is_smooth() {
            return Some(BsdfSample::mirrored(self.retroreflectance * active, wo, lobe));
        } else {
            self.distribution.sample_reflection(mirrored(wo), u)?.0
        };
        let BsdfEval { f, pdf } = self.eval(wo, wi);
        (pdf.0 > 0.0).then(|| BsdfSample::reflected(f, wi, pdf))
    }

    #[inline]
    fn traits(&self) -> Traits {
        Traits {
            has_lobes: true,
            is_delta: self.distribution.is_smooth() && self.reflectance.is_black(),
            casts_caustics: self.distribution.is_near_specular() && !self.retroreflectance.is_black(),
            ..Traits::default()
        }
    }
}

#[inline]
fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(-w.x, -w.y, w.z)
}
