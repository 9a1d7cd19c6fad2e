//! The global operator of Reinhard et al. ([Reinhard02](photosite_core::references#reinhard02)):
//!
//! L = a·L_w/L̄_w (eq. 2), L_d = L·(1 + L/L_white²)/(1 + L) (eq. 4; eq. 3 where L_white is infinite),
//!
//! with the luminance L_w, its logarithmic mean L̄_w (eq. 1) and the key a.

use photosite_core::rows::values;

use super::luminances::{brightest, logarithmic_mean};

/// Luminance that is shown; without a `white`, that of the brightest pixel. `black`: how far noise takes black.
pub(super) fn shown(light: &[f32], black: f32, key: f64, white: Option<f64>) -> Vec<f32> {
    let scale = key / logarithmic_mean(light, black);
    let white = white.unwrap_or(scale * f64::from(brightest(light)));
    let curve = |i: usize| {
        let l = scale * f64::from(light[i]);
        // An image without light has no white.
        let highlights = if white > 0.0 { l / (white * white) } else { 0.0 };
        (l * (1.0 + highlights) / (1.0 + l)) as f32
    };
    values(light.len(), curve)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_becomes_the_key_over_one_more() {
        let light = [0.01, 1.0, 100.0];
        // The logarithmic mean is 1, so L = 0.18·light, and without white 0.18/1.18 is shown of it.
        let found = shown(&light, 0.0, 0.18, Some(f64::INFINITY));
        for (found, light) in found.iter().zip([0.0018, 0.18, 18.0]) {
            assert!((f64::from(*found) - light / (1.0 + light)).abs() < 1e-6, "{found}");
        }
        let found = shown(&light, 0.0, 0.18, Some(2.0));
        assert!((f64::from(found[2]) - 18.0 * (1.0 + 18.0 / 4.0) / 19.0).abs() < 1e-5, "{found:?}");
    }
}
