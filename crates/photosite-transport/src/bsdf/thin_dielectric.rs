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

use super::fresnel;
use super::{BsdfSample, is_above};
use photosite_core::spectrum::SampledSpectrum;

/// Reflectance and transmittance of the pane at the cosine `cos`.
#[inline]
pub(super) fn parts(
    eta: SampledSpectrum,
    transmittance: SampledSpectrum,
    cos: f32,
) -> (SampledSpectrum, SampledSpectrum) {
    let lane = |i: usize| {
        let interface = fresnel::dielectric(cos, eta[i]);
        let (r, t) = (interface.reflectance, interface.transmittance);
        if interface.cos_transmitted <= 0.0 {
            return (1.0, 0.0);
        }
        let once = transmittance[i].powf(1.0 / interface.cos_transmitted);
        // 1 − R²a² = (1 − Ra)(1 + Ra), its first factor from what does not cancel.
        let passed = t * t * once / ((t + r * (1.0 - once)) * (1.0 + r * once)).max(f32::MIN_POSITIVE);
        (r + r * once * passed, passed)
    };
    let lanes = [0, 1, 2, 3].map(lane);
    (SampledSpectrum::from(lanes.map(|(r, _)| r)), SampledSpectrum::from(lanes.map(|(_, t)| t)))
}

#[inline]
pub(super) fn sample(
    eta: SampledSpectrum,
    transmittance: SampledSpectrum,
    wo: Vec3,
    u_lobe: f32,
) -> Option<BsdfSample> {
    if !is_above(wo) {
        return None;
    }
    let (reflected, passed) = parts(eta, transmittance, wo.z.min(1.0));
    let part = reflected.mean() / (reflected.mean() + passed.mean());
    if u_lobe < part {
        return Some(BsdfSample::mirrored(reflected, Vec3::new(-wo.x, -wo.y, wo.z), part));
    }
    let straight = BsdfSample { is_transmission: true, ..BsdfSample::mirrored(passed, -wo, 1.0 - part) };
    (straight.pdf.0 > 0.0).then_some(straight)
}
