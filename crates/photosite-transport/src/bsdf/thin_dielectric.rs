//! Panes: two polished parallel surfaces so close that light goes on where it came in.
//!
//! With R the reflectance of one surface and a = τ^(1/cos θ') what is left of light that crosses the pane once, τ the
//! internal transmittance along the normal and θ' the angle inside, the bounces between the surfaces add up to
//! ([BornWolf99](photosite_core::references#bornwolf99) §7.6, without interference)
//!
//! T = (1 − R)²·a/(1 − R²·a²), R' = R + R·a·T.
//!
//! Light goes straight on, so that all wavelengths stay together whatever the dispersion.

use glam::Vec3;

use super::directions::is_above;
use super::form::{Form, Map, Sampled, TableForm};
use super::fresnel;
use super::lobe::{Lobe, SceneTraits, Traits};
use super::sample::{BsdfEval, BsdfSample};
use photosite_core::spectrum::SampledSpectrum;

/// A polished pane with two parallel surfaces.
#[derive(Clone, Copy, Debug)]
pub struct ThinDielectric<F: Form = Sampled> {
    /// Refractive index of the glass.
    pub index: F::Index,
    /// Internal transmittance τ of the pane along the normal, without its surfaces, 0–1.
    pub transmittance: F::Spectrum,
}

impl<F: Form> ThinDielectric<F> {
    #[inline]
    pub(super) fn map<T: Form>(&self, map: &mut impl Map<F, T>) -> ThinDielectric<T> {
        ThinDielectric { index: map.index(&self.index), transmittance: map.spectrum(&self.transmittance) }
    }
}

impl<F: TableForm> SceneTraits for ThinDielectric<F> {
    fn may_cast_caustics(&self) -> bool {
        true
    }

    fn may_pass_straight(&self) -> bool {
        true
    }
}

impl ThinDielectric {
    /// Reflectance and transmittance of the pane at the cosine `cos`.
    #[inline]
    fn parts(&self, cos: f32) -> (SampledSpectrum, SampledSpectrum) {
        let lane = |i: usize| {
            let interface = fresnel::dielectric(cos, self.index.eta[i]);
            let (r, t) = (interface.reflectance, interface.transmittance);
            if interface.cos_transmitted <= 0.0 {
                return (1.0, 0.0);
            }
            let once = self.transmittance[i].powf(1.0 / interface.cos_transmitted);
            // 1 − R²a² = (1 − Ra)(1 + Ra), its first factor from what does not cancel.
            let passed = t * t * once / ((t + r * (1.0 - once)) * (1.0 + r * once)).max(f32::MIN_POSITIVE);
            (r + r * once * passed, passed)
        };
        let lanes = [0, 1, 2, 3].map(lane);
        (SampledSpectrum::from(lanes.map(|(r, _)| r)), SampledSpectrum::from(lanes.map(|(_, t)| t)))
    }
}

impl Lobe for ThinDielectric {
    #[inline]
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> BsdfEval {
        BsdfEval::ZERO
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        if !is_above(wo) {
            return None;
        }
        let (reflected, passed) = self.parts(wo.z.min(1.0));
        let part = reflected.mean() / (reflected.mean() + passed.mean());
        if u_lobe < part {
            return Some(BsdfSample::mirrored(reflected, Vec3::new(-wo.x, -wo.y, wo.z), part));
        }
        let straight = BsdfSample { is_transmission: true, ..BsdfSample::mirrored(passed, -wo, 1.0 - part) };
        (straight.pdf.0 > 0.0).then_some(straight)
    }

    #[inline]
    fn straight(&self, wo: Vec3) -> SampledSpectrum {
        if is_above(wo) { self.parts(wo.z.min(1.0)).1 } else { SampledSpectrum::ZERO }
    }

    #[inline]
    fn traits(&self) -> Traits {
        Traits { has_lobes: true, transmits: true, is_delta: true, casts_caustics: true, ..Traits::default() }
    }
}
