//! Light that bounces more than once between microfacets, which a lobe of one bounce loses.
//!
//! Such a lobe gives back E(w) of the light from w (`albedo`). What it leaves, R(w) = 1 − E(w), is spread as
//! f = c·R(wo)·R(wi) ([Kelemen01](photosite_core::references#kelemen01)): reciprocal, and ∫ f·cos θᵢ dωᵢ = π·c·R̄·R(wo)
//! with R̄ the mean over the hemisphere. Here is what c is made of.

use std::f32::consts::FRAC_1_PI;

use super::fresnel;
use photosite_core::spectrum::SampledSpectrum;

/// Remainders with a smaller mean are no more than rounding of the tables.
pub(super) const NOTHING_LEFT: f32 = 1e-5;

/// Part of R that metal facets of mean reflectance F̄ give back after further bounces, times `part`: F̄²·Ē/(1 − F̄(1 −
/// Ē)), Ē the mean albedo of white facets ([KullaConty17](photosite_core::references#kullaconty17)).
#[inline]
pub(super) fn further_bounces(part: f32, mean_reflectance: SampledSpectrum, mean_albedo: f32) -> SampledSpectrum {
    let f = mean_reflectance;
    f * f * (part * mean_albedo) / (SampledSpectrum::ONE - f * (1.0 - mean_albedo))
}

/// Shares of reflection and transmission in the light that one bounce at an interface of two clear media leaves.
pub(super) struct Shared {
    /// Factors c of radiance on that side and on the other.
    pub(super) scales: [f32; 2],
    /// The part that crosses.
    pub(super) crossing: f32,
}

/// Returns the shares for the index `eta` of the other side over this one and R̄ on both, times `part`; `None` where
/// nothing is left. As much is let in as on average at one bounce, but for what reciprocity forbids.
#[inline]
pub(super) fn shared_out(part: f32, eta: f32, [here, there]: [f32; 2]) -> Option<Shared> {
    let let_in = 1.0 - fresnel::mean_dielectric(eta);
    let most = here.max(there);
    (most > NOTHING_LEFT).then(|| {
        let crossing = let_in * there / most;
        let over_squared_index = FRAC_1_PI * let_in / (most * eta * eta);
        let scales = [part * FRAC_1_PI * (1.0 - crossing) / here.max(NOTHING_LEFT), part * over_squared_index];
        Shared { scales, crossing }
    })
}
