//! Adaptive logarithmic mapping ([Drago03](photosite_core::references#drago03), eq. 4), for a display whose brightest
//! luminance is 1:
//!
//! L_d = log₁₀(L + 1)/log₁₀(L_max + 1) · ln 10/ln(2 + 8·(L/L_max)^(ln b/ln ½)), L = L_w/L̄_w,
//!
//! with the luminance L_w, its logarithmic mean L̄_w and the bias b.

use photosite_core::rows::values;

use super::luminances::{brightest, logarithmic_mean};

/// Luminance that is shown. `black`: how far noise takes black.
pub(super) fn shown(light: &[f32], black: f32, bias: f64) -> Vec<f32> {
    let mean = logarithmic_mean(light, black);
    let max = f64::from(brightest(light)) / mean;
    let exponent = bias.ln() / 0.5f64.ln();
    let scale = 10f64.ln() / max.ln_1p();
    let curve = |i: usize| {
        if light[i] <= 0.0 {
            return 0.0;
        }
        let l = f64::from(light[i]) / mean;
        (scale * l.ln_1p() / (2.0 + 8.0 * (l / max).powf(exponent)).ln()) as f32
    };
    values(light.len(), curve)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bias_of_one_is_the_common_logarithm() {
        let light = [0.1, 1.0, 10.0];
        for (found, light) in shown(&light, 0.0, 1.0).iter().zip(light) {
            let expected = (f64::from(light) + 1.0).log10() / 11f64.log10();
            assert!((f64::from(*found) - expected).abs() < 1e-6, "{found} {expected}");
        }
        // With b = ½ the base is 2 + 8·L/L_max: by hand, ln(2)/ln(2.8)·ln(10)/ln(11).
        let found = shown(&light, 0.0, 0.5)[1];
        assert!((found - 0.646_449).abs() < 1e-5, "{found}");
    }
}
