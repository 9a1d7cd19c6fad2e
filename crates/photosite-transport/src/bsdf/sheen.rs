//! Sheen: the light that fibres standing on a surface scatter, as on velvet.
//!
//! glTF's `KHR_materials_sheen`, "Sheen distribution" and "Sheen visibility", after
//! [Estevez17](photosite_core::references#estevez17): α = roughness², D = (2 + 1/α)·sin^(1/α) θ_h/(2π), G = 1/(1 +
//! Λ(cos θₒ) + Λ(cos θᵢ)) with the fit of Λ that is given there, f = colour·D·G/(4·cos θₒ·cos θᵢ). No Fresnel factor.
//!
//! The published lobe of α < 0.06 gives back more than arrives near the horizon, E(w) = ∫ f·cos θᵢ dωᵢ up to 2.1. Here
//! it is divided by max(1, E(wo), E(wi)): reciprocal, at most 1 in all, and as published wherever that conserves energy.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::directions::is_above;

/// Smallest α, below which the lobe is too narrow a rim to be integrated; the default roughness 0 becomes this α.
pub(super) const SMALLEST_ALPHA: f32 = 0.01;

/// Cosines below this count as this, so that E has a limit along the surface.
const SMALLEST_COSINE: f32 = 1e-4;

/// The published f for a colour of 1; both directions above the surface.
#[inline]
pub(super) fn published(alpha: f32, wo: Vec3, wi: Vec3) -> f32 {
    if !(is_above(wo) && is_above(wi)) {
        return 0.0;
    }
    let alpha = alpha.max(SMALLEST_ALPHA);
    let hidden = 1.0 + lambda(wo.z, alpha) + lambda(wi.z, alpha);
    density((wo + wi).normalize().z, alpha) / (hidden * 4.0 * at_least(wo.z) * at_least(wi.z))
}

#[inline]
fn at_least(cos: f32) -> f32 {
    cos.max(SMALLEST_COSINE)
}

/// D.
#[inline]
fn density(cos_half: f32, alpha: f32) -> f32 {
    let sin_squared = (1.0 - cos_half * cos_half).max(0.0);
    let inverse = 1.0 / alpha;
    (2.0 + inverse) * sin_squared.powf(0.5 * inverse) / TAU
}

/// Area hidden over area seen.
#[inline]
fn lambda(cos: f32, alpha: f32) -> f32 {
    let cos = at_least(cos);
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

/// Albedos for a colour of 1 at the cosines (i/(`nodes` − 1))²: E of the published lobe, and that of the lobe in use,
/// ∫ f/max(1, E(wo), E(wi))·cos θᵢ dωᵢ.
pub(super) fn albedos(alpha: f32, nodes: usize) -> Vec<Vec2> {
    const AZIMUTHS: usize = 32;
    let step = 1.0 / (nodes - 1) as f32;
    let cosines: Vec<f32> = (0..nodes).map(|i| at_least((i as f32 * step).powi(2))).collect();
    // ∫ f·z dz by the trapezoidal rule in √z, dz = 2√z d√z: the lobe hugs the horizon.
    let weights: Vec<f32> =
        (0..nodes).map(|i| 2.0 * step * (i as f32 * step).powi(3) * if i == nodes - 1 { 0.5 } else { 1.0 }).collect();
    let hidden: Vec<f32> = cosines.iter().map(|&cos| lambda(cos, alpha)).collect();
    // ∫ f dφ, the same both ways.
    let mut kernel = vec![0.0; nodes * nodes];
    for (i, j) in (0..nodes).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        let (a, b) = (cosines[i], cosines[j]);
        let sines = ((1.0 - a * a) * (1.0 - b * b)).sqrt();
        let mean = (0..AZIMUTHS)
            .map(|k| {
                let azimuth = 0.5 * TAU * (k as f32 + 0.5) / AZIMUTHS as f32;
                let squared_length = 2.0 * (1.0 + a * b + sines * azimuth.cos());
                density((a + b) / squared_length.sqrt().max(a + b), alpha)
            })
            .sum::<f32>()
            / AZIMUTHS as f32;
        let f = mean * TAU / ((1.0 + hidden[i] + hidden[j]) * 4.0 * a * b);
        (kernel[i * nodes + j], kernel[j * nodes + i]) = (f, f);
    }
    let integral = |i: usize, g: &dyn Fn(usize) -> f32| -> f32 {
        (0..nodes).map(|j| kernel[i * nodes + j] * weights[j] * g(j)).sum()
    };
    let published: Vec<f32> = (0..nodes).map(|i| integral(i, &|_| 1.0)).collect();
    let used = |i: usize| integral(i, &|j| 1.0 / published[i].max(published[j]).max(1.0));
    (0..nodes).map(|i| Vec2::new(published[i], used(i))).collect()
}
