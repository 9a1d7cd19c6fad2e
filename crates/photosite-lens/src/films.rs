//! Refraction and transmittance of a lens's surfaces at each wavelength, tabulated for rays in lanes: the ratio of the
//! indices, and the transmittance of the films as a polynomial in the cosine of the angle of incidence.
//!
//! Transmittance is a smooth function of the cosine in the thinner medium, and the same from both sides. Interpolated at
//! the five zeros of a Chebyshev polynomial between normal incidence and the steepest ray of a surface it is right to some
//! 1e-4 where rays come no steeper than 60°.

use std::array;
use std::f64::consts::PI;

use photosite_core::spectrum::{LAMBDA_MIN_NM, TABLE_LEN};

use crate::coating::transmittance_of;
use crate::lens::Lens;
use crate::profile::Travel;

/// Number of coefficients of a polynomial, and of all terms of a surface.
const COEFFICIENTS: usize = 5;
pub(crate) const TERMS: usize = 1 + COEFFICIENTS;
/// Range of the smallest cosine of a polynomial.
const STEEPEST: [f64; 2] = [0.02, 0.9];

/// A surface at a wavelength.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Film {
    /// Index before the surface over the index behind it, for light to the sensor, and the reciprocal.
    ratios: [f32; 2],
    /// Coefficients of the transmittance, by powers of the scaled cosine.
    coefficients: [f32; COEFFICIENTS],
}

impl Film {
    /// Index before over index behind, then the coefficients.
    #[inline(always)]
    pub(crate) fn terms(&self, travel: Travel) -> [f32; TERMS] {
        let [ratio, reciprocal] = self.ratios;
        let [a, b, c, d, e] = self.coefficients;
        match travel {
            Travel::ToSensor => [ratio, a, b, c, d, e],
            Travel::ToScene => [reciprocal, a, b, c, d, e],
        }
    }
}

/// All surfaces of a lens at each whole nanometre from 300 to 1100.
#[derive(Clone, Debug)]
pub(crate) struct Films {
    /// Films by wavelength, then by surface.
    films: Vec<Film>,
    /// Middle of the cosines and half their range, by surface.
    ranges: Vec<[f32; 2]>,
}

impl Films {
    /// Films of a lens, for rays that meet each surface at cosines from `steepest` to 1 in the thinner medium.
    pub(crate) fn new(lens: &Lens, steepest: &[f64]) -> Self {
        let [least, most] = STEEPEST;
        let range = |steepest: &f64| {
            let steepest = steepest.clamp(least, most);
            [0.5 * (1.0 + steepest), 0.5 * (1.0 - steepest)]
        };
        let ranges: Vec<[f64; 2]> = steepest.iter().map(range).collect();
        let mut films = Vec::new();
        for i in 0..TABLE_LEN {
            let at = lens.at(f64::from(LAMBDA_MIN_NM) + i as f64);
            films.extend(ranges.iter().enumerate().map(|(surface, [middle, half])| {
                let ratio = at.index_before(surface) / at.index_before(surface + 1);
                let through = |x: f64| transmittance_of(&at, surface, middle + half * x);
                Film { ratios: [ratio as f32, (1.0 / ratio) as f32], coefficients: interpolated(through) }
            }));
        }
        Self { films, ranges: ranges.iter().map(|range| range.map(|x| x as f32)).collect() }
    }

    /// Films of all surfaces, `nm` nanometres above the first wavelength.
    #[inline(always)]
    pub(crate) fn at(&self, nm: usize) -> &[Film] {
        let count = self.ranges.len();
        &self.films[nm * count..(nm + 1) * count]
    }

    /// Middle of the cosines of a surface, and half their range.
    #[inline(always)]
    pub(crate) fn range(&self, surface: usize) -> [f32; 2] {
        self.ranges[surface]
    }
}

/// Coefficients, by powers of x, of the polynomial that equals a function at the five zeros of T₅.
fn interpolated(f: impl Fn(f64) -> f64) -> [f32; COEFFICIENTS] {
    let count = COEFFICIENTS as f64;
    let angle = |i: usize| PI * (i as f64 + 0.5) / count;
    let values: [f64; COEFFICIENTS] = array::from_fn(|i| f(angle(i).cos()));
    // Those of T₀ … T₄.
    let [a0, a1, a2, a3, a4] = array::from_fn(|k| {
        let sum: f64 = (0..COEFFICIENTS).map(|i| values[i] * (k as f64 * angle(i)).cos()).sum();
        if k == 0 { sum / count } else { 2.0 * sum / count }
    });
    [a0 - a2 + a4, a1 - 3.0 * a3, 2.0 * a2 - 8.0 * a4, 4.0 * a3, 8.0 * a4].map(|a: f64| a as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quartic_is_its_own_interpolation() {
        let coefficients = interpolated(|x| 0.3 + x * (-0.2 + x * (0.5 + x * (0.7 - 0.4 * x))));
        for (found, expected) in coefficients.iter().zip([0.3, -0.2, 0.5, 0.7, -0.4]) {
            assert!((found - expected).abs() < 1e-6, "{coefficients:?}");
        }
    }
}
