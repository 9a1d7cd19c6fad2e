//! Fitting a [`SigmoidPolynomial`] to a colour: coefficients of a reflectance that has a given linear sRGB under D65.

use std::sync::OnceLock;

use glam::{DMat3, DVec3, DVec4};

use super::polynomial::{RANGE_NM, value_and_gradient};
use crate::spectrum::{cie, illuminant, rgb};

/// Number of wavelengths that colours are integrated over: every nanometre of [`RANGE_NM`].
const STEPS: usize = (RANGE_NM[1] - RANGE_NM[0]) as usize + 1;

/// Contribution of a reflectance of 1 at one nanometre to linear sRGB under D65. The sum over all is (1, 1, 1).
fn weights() -> &'static [DVec3; STEPS] {
    static WEIGHTS: OnceLock<Box<[DVec3; STEPS]>> = OnceLock::new();
    WEIGHTS.get_or_init(|| {
        let light = illuminant::d65();
        let y = cie::xyz(light)[1];
        Box::new(std::array::from_fn(|i| {
            let lambda = RANGE_NM[0] + i as f32;
            let xyz = cie::observer().each_ref().map(|bar| f64::from(bar.eval(lambda)));
            *rgb::xyz_to_rgb() * DVec3::from_array(xyz) * (f64::from(light.eval(lambda)) / y)
        }))
    })
}

/// Linear sRGB under D65 of the polynomial with homogeneous coordinates `v`, and its derivatives by them.
fn colour_and_gradient(v: DVec4) -> (DVec3, [DVec3; 4]) {
    let mut colour = DVec3::ZERO;
    let mut gradient = [DVec3::ZERO; 4];
    for (i, &weight) in weights().iter().enumerate() {
        let (value, by_v) = value_and_gradient(v, f64::from(RANGE_NM[0]) + i as f64);
        colour += weight * value;
        for (sum, derivative) in gradient.iter_mut().zip(by_v.to_array()) {
            *sum += weight * derivative;
        }
    }
    (colour, gradient)
}

/// Linear sRGB under D65 of the polynomial with homogeneous coordinates `v`.
#[cfg(test)]
pub(super) fn colour(v: DVec4) -> DVec3 {
    colour_and_gradient(v).0
}

/// Outcome of a fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Homogeneous coordinates, of length 1.
    pub(super) v: DVec4,
    /// Largest difference of a channel of linear sRGB.
    pub(super) error: f64,
}

/// Looks for homogeneous coordinates whose colour is `target`, from `start`, by Levenberg–Marquardt in at most
/// `iterations` steps.
///
/// There are three equations for four coordinates of which the length does not matter: the step is the shortest that
/// solves the linearised equations, δ = Jᵀ(JJᵀ + μI)⁻¹r, which is at right angles to v.
pub(super) fn fit(target: DVec3, start: DVec4, iterations: usize) -> Fit {
    let mut v = start.normalize();
    let (mut found, mut gradient) = colour_and_gradient(v);
    let mut damping = 1e-12;
    for _ in 0..iterations {
        let residual = target - found;
        let error = residual.length_squared();
        if error == 0.0 {
            break;
        }
        let jjt = gradient.iter().map(|&column| outer(column)).fold(DMat3::ZERO, |a, b| a + b);
        let trace = jjt.x_axis.x + jjt.y_axis.y + jjt.z_axis.z;
        let solution =
            (jjt + DMat3::from_diagonal(DVec3::splat(damping * trace + f64::MIN_POSITIVE))).inverse() * residual;
        let step = DVec4::from_array(gradient.map(|column| column.dot(solution)));
        // A step longer than the radius of the sphere says that the linearisation does not hold.
        let step = step.clamp_length_max(0.5);
        let candidate = (v + step).normalize();
        // w and −w are the same spectrum.
        let candidate = DVec4::new(candidate.x, candidate.y, candidate.z, candidate.w.abs());
        if !candidate.is_finite() {
            damping = (damping * 100.0).max(1e-6);
            continue;
        }
        let (candidate_colour, candidate_gradient) = colour_and_gradient(candidate);
        if (target - candidate_colour).length_squared() < error {
            (v, found, gradient) = (candidate, candidate_colour, candidate_gradient);
            damping = (damping * 0.1).max(1e-12);
        } else {
            damping = (damping * 10.0).max(1e-9);
            if damping > 1e6 {
                break;
            }
        }
    }
    Fit { v, error: (target - found).abs().max_element() }
}

/// Outer product of a column with itself.
fn outer(column: DVec3) -> DMat3 {
    DMat3::from_cols(column * column.x, column * column.y, column * column.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_corner_of_the_cube_is_reached_from_grey() {
        // The most saturated colours there are; black and white apart, which are limits.
        for corner in 1..7 {
            let target = DVec3::from_array([0, 1, 2].map(|channel| f64::from(corner >> channel & 1)));
            let fit = fit(target, DVec4::new(0.0, 0.0, 0.0, 1.0), 200);
            // Quadratic convergence: what remains are roundings of sums of 471 terms.
            assert!(fit.error < 1e-9, "{target}: {}", fit.error);
        }
    }

    #[test]
    fn weights_make_white_of_a_perfect_reflector() {
        // The observer's table ends where the sum does, so nothing of D65 is left out.
        assert!(weights().iter().sum::<DVec3>().abs_diff_eq(DVec3::ONE, 1e-12));
    }
}
