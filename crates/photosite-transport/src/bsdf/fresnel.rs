//! Fresnel reflectance of unpolarised light: how much of the light that meets a smooth interface turns back.
//!
//! In: the cosine of the angle of incidence and the refractive index of the far side relative to the near side. Out: a
//! fraction between 0 and 1, for clear media together with the cosine of the refracted ray. Polarisation is not
//! followed: the s and p reflectances are averaged, as for light that arrives unpolarised. Relative indices are
//! positive; extinction coefficients are not negative.

use glam::Vec4;

use photosite_core::spectrum::SampledSpectrum;

/// Reflection and transmission at an interface of two clear media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Reflected fraction R.
    pub reflectance: f32,
    /// Transmitted fraction T = 1 − R, to full precision where little gets through.
    pub transmittance: f32,
    /// Cosine of the angle of refraction, 0 in total internal reflection.
    pub cos_transmitted: f32,
}

/// Fresnel reflectance of an interface of two clear media: R = (r_p² + r_s²)/2 with r_p = (η·cos θᵢ − cos θₜ)/(η·cos θᵢ
/// + cos θₜ), r_s = (cos θᵢ − η·cos θₜ)/(cos θᵢ + η·cos θₜ) ([Pbrt4](photosite_core::references#pbrt4) §9.3.5).
///
/// `cos_incident` is between 0 and 1, `eta` = n_far/n_near. Snell's law is used as cos²θₜ = (η² − 1 + cos²θᵢ)/η², which
/// loses no digits at grazing incidence nor for η near 1, and gives cos θₜ = cos θᵢ exactly for η = 1.
#[inline]
pub fn dielectric(cos_incident: f32, eta: f32) -> Interface {
    let far_squared = (eta - 1.0) * (eta + 1.0) + cos_incident * cos_incident;
    if far_squared <= 0.0 {
        // Total internal reflection. Light that glides along an interface that is not there goes on gliding.
        let transmittance = if eta == 1.0 { 1.0 } else { 0.0 };
        return Interface { reflectance: 1.0 - transmittance, transmittance, cos_transmitted: 0.0 };
    }
    let cos_transmitted = (far_squared.sqrt() / eta).min(1.0);
    between(cos_incident, cos_transmitted, eta)
}

/// Fresnel reflectance of clear media where both cosines, above 0 and related by Snell's law, are known: near the
/// critical angle they hold more digits together than one alone.
#[inline]
pub fn between(cos_incident: f32, cos_transmitted: f32, eta: f32) -> Interface {
    let (eta_cos_incident, eta_cos_transmitted) = (eta * cos_incident, eta * cos_transmitted);
    let parallel = 1.0 / (eta_cos_incident + cos_transmitted);
    let perpendicular = 1.0 / (cos_incident + eta_cos_transmitted);
    let r_p = (eta_cos_incident - cos_transmitted) * parallel;
    let r_s = (cos_incident - eta_cos_transmitted) * perpendicular;
    Interface {
        reflectance: 0.5 * (r_p * r_p + r_s * r_s),
        // η·cos θₜ/cos θᵢ·t² with t = 2·cos θᵢ over the sum, for either polarisation.
        transmittance: 2.0 * cos_incident * eta_cos_transmitted * (parallel * parallel + perpendicular * perpendicular),
        cos_transmitted,
    }
}

/// Fresnel reflectance of a metal of complex index η + i·k seen from a clear medium (both relative to it), per
/// wavelength: R = (R_s + R_p)/2 with, for a + i·b = √((η + i·k)² − sin²θ),
/// R_s = (a² + b² − 2a·cos θ + cos²θ)/(a² + b² + 2a·cos θ + cos²θ),
/// R_p = R_s·(cos²θ·(a² + b²) − 2a·cos θ·sin²θ + sin⁴θ)/(cos²θ·(a² + b²) + 2a·cos θ·sin²θ + sin⁴θ)
/// ([BornWolf99](photosite_core::references#bornwolf99) §14.2).
///
/// `cos_incident` is between 0 and 1. k = 0 gives [`dielectric`], η = 0 a mirror without loss.
#[inline]
pub fn conductor(cos_incident: f32, eta: SampledSpectrum, k: SampledSpectrum) -> SampledSpectrum {
    const TINY: Vec4 = Vec4::splat(f32::MIN_POSITIVE);
    let cos_squared = cos_incident * cos_incident;
    let sin_squared = (1.0 - cos_squared).max(0.0);
    let (eta, k) = (eta.0, k.0);

    // The root of the complex number real + i·imaginary. The larger of a and b comes from a sum without cancellation,
    // the other from their product: silver has k ≫ η, and all that it absorbs is in the small a.
    let real = (eta - k) * (eta + k) - sin_squared;
    let half_imaginary = eta * k;
    let modulus = (real * real + 4.0 * half_imaginary * half_imaginary).sqrt();
    let larger = (0.5 * (modulus + real.abs())).sqrt();
    let a = Vec4::select(real.cmpge(Vec4::ZERO), larger, half_imaginary / larger.max(TINY));

    let sum = modulus + cos_squared;
    let cross = (2.0 * cos_incident) * a;
    let perpendicular = (sum - cross) / (sum + cross).max(TINY);
    let sum = cos_squared * modulus + sin_squared * sin_squared;
    let cross = sin_squared * cross;
    let ratio = (sum - cross) / (sum + cross).max(TINY);
    SampledSpectrum(0.5 * (perpendicular + perpendicular * ratio))
}

/// The weight of white in Schlick's approximation R ≈ F₀ + (1 − F₀)(1 − cos θ)⁵
/// ([Schlick94](photosite_core::references#schlick94)): (1 − cos θ)⁵.
#[inline]
pub fn schlick_weight(cos_incident: f32) -> f32 {
    let m = (1.0 - cos_incident).clamp(0.0, 1.0);
    let squared = m * m;
    squared * squared * m
}

/// Mean over the hemisphere of the reflectance of an interface, F̄
/// ([KullaConty17](photosite_core::references#kullaconty17)): for η > 1 a fit; for η < 1 by 1 − F̄(1/η) = η²(1 −
/// F̄(η)), what goes in being what comes out.
#[inline]
pub fn mean_dielectric(eta: f32) -> f32 {
    let denser = |eta: f32| (eta - 1.0) / (4.085_67 + 1.000_71 * eta);
    if eta >= 1.0 { denser(eta) } else { 1.0 - eta * eta * (1.0 - denser(1.0 / eta)) }
}

/// Mean over the hemisphere of the reflectance of a metal, ∫2μ·R(μ) dμ, by Gauss–Legendre quadrature with 4 points.
#[inline]
pub fn mean_conductor(eta: SampledSpectrum, k: SampledSpectrum) -> SampledSpectrum {
    const RULE: [(f32, f32); 4] = [
        (0.069_431_84, 0.173_927_42),
        (0.330_009_5, 0.326_072_58),
        (0.669_990_5, 0.326_072_58),
        (0.930_568_16, 0.173_927_42),
    ];
    RULE.iter().fold(SampledSpectrum::ZERO, |sum, &(mu, weight)| sum + conductor(mu, eta, k) * (2.0 * mu * weight))
}
