//! Thin films: how much a clear film on a surface reflects at each wavelength, with all interference.
//!
//! glTF's `KHR_materials_iridescence` approximates this in RGB; with a spectrum at hand Airy's sum is exact
//! ([BornWolf99](photosite_core::references#bornwolf99) §7.6.1, eq. 15): for either polarisation, with the amplitude
//! reflectances r₁ of air → film and r₂ of film → base and the phase δ = (4π/λ)·n·d·cos θ_f,
//!
//! R = (r₁² + r₂² + 2r₁r₂·cos δ)/(1 + r₁²r₂² + 2r₁r₂·cos δ).
//!
//! As in the extension ("Material Interfaces") the base is known by its reflectance F₀ at normal incidence alone and
//! gets the real index η = (1 + √F₀)/(1 − √F₀), metals too.

use std::f32::consts::TAU;

use glam::Vec4;

use photosite_core::spectrum::SampledSpectrum;

/// A clear film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinFilm {
    /// Part of the surface that the film covers, 0–1.
    pub weight: f32,
    /// Refractive index of the film, at least 1.
    pub index: f32,
    /// 2·n·d/λ: by how many waves light that crosses it twice along the normal falls behind.
    pub waves: SampledSpectrum,
}

/// The largest F₀ whose index is finite enough to compute with.
const LARGEST_F0: f32 = 0.9999;

impl ThinFilm {
    /// The reflectance of the film on a base of reflectance `f0` at normal incidence (without it), for light that
    /// arrives from air at the cosine `cos`, averaged over both polarisations.
    #[inline]
    pub fn reflectance(&self, cos: f32, f0: SampledSpectrum) -> SampledSpectrum {
        let root = f0.0.clamp(Vec4::ZERO, Vec4::splat(LARGEST_F0)).sqrt();
        let base = (1.0 + root) / (1.0 - root);
        let n = self.index;
        let sin_squared = (1.0 - cos * cos).max(0.0);
        let cos_film = (1.0 - sin_squared / (n * n)).max(0.0).sqrt();
        let cos_base = (1.0 - sin_squared / (base * base)).max(Vec4::ZERO).sqrt();
        let cos_delta = SampledSpectrum(self.waves.0 * (TAU * cos_film)).map(f32::cos).0;

        let airy = |r1: f32, r2: Vec4| {
            let cross = 2.0 * r1 * r2 * cos_delta;
            let (a, b) = (r1 * r1, r2 * r2);
            (a + b + cross) / (1.0 + a * b + cross)
        };
        // Along the surface itself the first amplitudes are 0/0 for a film of index 1.
        let (c, cf) = (cos.max(1e-6), cos_film.max(1e-6));
        let s = airy((c - n * cf) / (c + n * cf), (n * cf - base * cos_base) / (n * cf + base * cos_base));
        let p = airy((n * c - cf) / (n * c + cf), (base * cf - n * cos_base) / (base * cf + n * cos_base));
        SampledSpectrum((0.5 * (s + p)).clamp(Vec4::ZERO, Vec4::ONE))
    }
}
