//! Colour temperature and tint of a white: its position along the Planckian locus and its distance from it.
//!
//! The Planckian locus is the line of blackbodies in the CIE 1960 (u, v) diagram. The correlated colour temperature of
//! a white is that of the nearest point of the locus, D_uv its distance, positive above the locus, on the greenish
//! side. The tint is 3000·D_uv, the scale that photographers know from Adobe's programs.

use glam::DVec2;

use crate::spectrum::{cie, illuminant};

/// Tint of a D_uv of 1.
const TINT_SCALE: f64 = 3000.0;
/// Range of correlated colour temperatures, K.
pub const TEMPERATURE_RANGE_K: [f64; 2] = [1000.0, 40_000.0];

/// Chromaticity (x, y) of the white of a temperature (K) and tint. `None` outside [`TEMPERATURE_RANGE_K`], or where the
/// tint leaves the diagram.
pub fn chromaticity(temperature_k: f64, tint: f64) -> Option<[f64; 2]> {
    let [low, high] = TEMPERATURE_RANGE_K;
    if !(low..=high).contains(&temperature_k) || !tint.is_finite() {
        return None;
    }
    let DVec2 { x: u, y: v } = locus(temperature_k) + normal(temperature_k) * (tint / TINT_SCALE);
    let denominator = 2.0 * u - 8.0 * v + 4.0;
    let [x, y] = [3.0 * u / denominator, 2.0 * v / denominator];
    (x > 0.0 && y > 0.0 && x + y < 1.0).then_some([x, y])
}

/// Correlated colour temperature (K) and tint of a chromaticity (x, y). The temperature is held within
/// [`TEMPERATURE_RANGE_K`].
pub fn temperature_and_tint([x, y]: [f64; 2]) -> (f64, f64) {
    let uv = DVec2::new(4.0 * x, 6.0 * y) / (-2.0 * x + 12.0 * y + 3.0);
    // The distance to the line falls and rises once over the reciprocal temperature: golden-section search.
    let distance = |mired: f64| locus(1e6 / mired).distance_squared(uv);
    let [hot, cold] = TEMPERATURE_RANGE_K.map(|k| 1e6 / k);
    let (mut low, mut high) = (cold.min(hot), cold.max(hot));
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    // 0.618^60 of 975 mired is below 1e-9 mired.
    for _ in 0..60 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if distance(a) < distance(b) { high = b } else { low = a }
    }
    let temperature = 1e6 / (0.5 * (low + high));
    (temperature, (uv - locus(temperature)).dot(normal(temperature)) * TINT_SCALE)
}

/// Chromaticity (u, v) of a blackbody.
fn locus(temperature_k: f64) -> DVec2 {
    let [mut x, mut y, mut z] = [0.0; 3];
    let [x_bar, y_bar, z_bar] = cie::observer();
    // Steps of the observer's table. With those of 5 nm hot blackbodies would be off by 3e-6.
    for lambda in 360..=830 {
        let radiance = illuminant::planck(f64::from(lambda), temperature_k);
        let bar = |bar: &crate::spectrum::Spectrum| f64::from(bar.eval(lambda as f32)) * radiance;
        (x, y, z) = (x + bar(x_bar), y + bar(y_bar), z + bar(z_bar));
    }
    DVec2::new(4.0 * x, 6.0 * y) / (x + 15.0 * y + 3.0 * z)
}

/// Unit normal of the Planckian locus in (u, v), towards green.
fn normal(temperature_k: f64) -> DVec2 {
    let along = locus(temperature_k * 0.999) - locus(temperature_k * 1.001);
    along.perp().normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_lights_have_their_temperatures() {
        // CIE 015:2018 and, of D_uv, ANSI C78.377: daylight lies about 0.0033 above the blackbodies.
        for (name, temperature, tint, tolerance) in
            [("A", 2856.0, 0.0, 2.0), ("D65", 6503.0, 9.7, 4.0), ("D50", 5002.0, 9.7, 4.0), ("4000K", 4000.0, 0.0, 0.1)]
        {
            let xy = cie::chromaticity(&illuminant::illuminant(name).expect("known")).expect("not black");
            let (t, found) = temperature_and_tint(xy);
            assert!((t - temperature).abs() < tolerance && (found - tint).abs() < 0.5, "{name}: {t} K, tint {found}");
        }
    }

    #[test]
    fn both_ways_undo_each_other() {
        for temperature in [2000.0, 2856.0, 5000.0, 12_000.0] {
            for tint in [-30.0, 0.0, 30.0] {
                let xy = chromaticity(temperature, tint).expect("in range");
                let (t, found) = temperature_and_tint(xy);
                // Near a minimum f64 tells distances apart only to the square root of its digits.
                assert!((t / temperature - 1.0).abs() < 1e-4 && (found - tint).abs() < 1e-2, "{t} K, tint {found}");
            }
        }
        let [green, neutral] = [100.0, 0.0].map(|tint| chromaticity(5000.0, tint).expect("in range"));
        assert!(green[1] > neutral[1] + 0.01, "a positive tint is greener");
        assert!(
            [(900.0, 0.0), (f64::NAN, 0.0), (5000.0, f64::NAN), (5000.0, 1e9)].map(|(t, d)| chromaticity(t, d))
                == [None; 4]
        );
    }
}
