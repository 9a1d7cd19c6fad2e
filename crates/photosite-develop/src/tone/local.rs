//! The local operator of Durand and Dorsey ([Durand02](photosite_core::references#durand02)): a bilateral filter parts
//! log₁₀ L in a base B, which follows edges, and in detail D. The base is compressed, the detail stays:
//!
//! log₁₀ L_d = γ·(B − max B) + D, γ = log₁₀(contrast)/(max B − min B), at most 1.

use photosite_core::rows::values;

use super::fast_bilateral::smoothed;
use super::luminances::brightest;

/// Darkest luminance whose logarithm is taken, as a part of the brightest pixel; below it, or below noise of black,
/// light goes down in proportion, since logarithms of black have no end.
const DARKEST: f32 = 1e-5;

/// Luminance that is shown. `black`: how far noise takes black.
pub(super) fn shown(
    light: &[f32],
    black: f32,
    size: [usize; 2],
    [sigma_px, sigma_range]: [f64; 2],
    contrast: f64,
) -> Vec<f32> {
    let floor = (brightest(light) * DARKEST).max(black);
    if floor <= 0.0 {
        return vec![0.0; light.len()];
    }
    let logarithms = values(light.len(), |i| light[i].max(floor).log10());
    let base = smoothed(&logarithms, size, sigma_px, sigma_range);
    let high = base.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let low = base.iter().copied().fold(f32::INFINITY, f32::min);
    let compression = (contrast.log10() as f32 / (high - low)).min(1.0);
    values(light.len(), |i| {
        10f32.powf(compression * (base[i] - high) + (logarithms[i] - base[i])) * (light[i] / floor).min(1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_base_is_compressed_and_detail_stays() {
        // Two halves of 1 to 10 000, each with stripes of a tenth.
        let value = |i: usize| {
            let half = if i % 64 < 32 { 1e-4 } else { 1.0 };
            half * if i.is_multiple_of(2) { 1.0 } else { 1.1 }
        };
        let light: Vec<f32> = (0..64 * 48).map(value).collect();
        let found = shown(&light, 0.0, [64, 48], [3.0, 0.4], 100.0);
        let (dark, bright) = (20 * 64 + 10, 20 * 64 + 54);
        for i in [dark, bright] {
            assert!((found[i + 1] / found[i] - 1.1).abs() < 2e-3, "{}", found[i + 1] / found[i]);
        }
        assert!((found[bright] / found[dark] / 100.0 - 1.0).abs() < 0.01, "{}", found[bright] / found[dark]);
        // Less contrast than is asked for stays as it is.
        let flat = shown(&[0.5, 0.25, 0.5, 0.25], 0.0, [2, 2], [1.0, 0.4], 50.0);
        assert!((flat[0] / flat[1] - 2.0).abs() < 1e-4);
    }
}
