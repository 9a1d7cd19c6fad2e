//! Sheen: the light that fibres standing on a surface scatter, as on velvet.
//!
//! glTF's `KHR_materials_sheen`, "Sheen distribution" and "Sheen visibility", after
//! [Estevez17](photosite_core::references#estevez17): α = roughness², D = (2 + 1/α)·sin^(1/α) θ_h/(2π), G = 1/(1 +
//! Λ(cos θₒ) + Λ(cos θᵢ)) with the fit of Λ that is given there, f = colour·D·G/(4·cos θₒ·cos θᵢ). No Fresnel factor.

use std::f32::consts::TAU;

use glam::Vec3;

use super::directions::is_above;

/// Below this α the lobe is so narrow a rim that it cannot be integrated; also what the default roughness 0 becomes.
const SMALLEST_ALPHA: f32 = 0.01;

/// f for a colour of 1; both directions above the surface.
#[inline]
pub(super) fn value(alpha: f32, wo: Vec3, wi: Vec3) -> f32 {
    if !(is_above(wo) && is_above(wi)) {
        return 0.0;
    }
    let alpha = alpha.max(SMALLEST_ALPHA);
    let cos_half = (wo + wi).normalize().z;
    let sin_squared = (1.0 - cos_half * cos_half).max(0.0);
    let inverse = 1.0 / alpha;
    let density = (2.0 + inverse) * sin_squared.powf(0.5 * inverse) / TAU;
    density / ((1.0 + lambda(wo.z, alpha) + lambda(wi.z, alpha)) * 4.0 * wo.z * wi.z)
}

/// Area hidden over area seen.
#[inline]
fn lambda(cos: f32, alpha: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let fit = |at_one: f32, at_zero: f32| at_one + (at_zero - at_one) * t;
    let a = fit(21.5473, 25.3245);
    let b = fit(3.829_87, 3.324_35);
    let c = fit(0.198_23, 0.168_01);
    let d = fit(-1.977_60, -1.273_93);
    let e = fit(-4.320_54, -4.859_67);
    let l = |x: f32| a / (1.0 + b * x.powf(c)) + d * x + e;
    if cos < 0.5 { l(cos).exp() } else { (2.0 * l(0.5) - l(1.0 - cos)).exp() }
}

/// ∫ f·cos θᵢ dωᵢ for a colour of 1, by the midpoint rule over cosine and azimuth.
pub(super) fn albedo(alpha: f32, mu: f32) -> f32 {
    const STEPS: usize = 48;
    let wo = Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu.max(1e-4));
    let at = |i: usize| (i as f32 + 0.5) / STEPS as f32;
    let mut sum = 0.0;
    for i in 0..STEPS {
        // Steps in √z: the lobe hugs the horizon.
        let (z, width) = (at(i) * at(i), 2.0 * at(i) / STEPS as f32);
        let radius = (1.0 - z * z).sqrt();
        for j in 0..STEPS {
            let (sin, cos) = (0.5 * TAU * at(j)).sin_cos();
            sum += value(alpha, wo, Vec3::new(radius * cos, radius * sin, z)) * z * width;
        }
    }
    sum * TAU / STEPS as f32
}
