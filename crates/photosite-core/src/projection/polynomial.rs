//! Polynomial distortion of lecture notes, from the distorted to the ideal image: u = u_d·(1 + k₁r² + k₂r⁴), r = |u_d|.
//!
//! The direction is opposite to OpenCV's model, so coefficients of the same sign distort the opposite way: k₁ > 0 is a
//! barrel here. Radii are those of the distorted image.

use glam::{DVec2, DVec3};

use super::CalibrationModel;
use super::model::{Model, Seen};
use super::perspective::{on_plane, through_plane};
use super::reach::{FLAT_ANGLE, Reach, ReachEnd};
use super::rising::{first_loss, solve};

/// k₁, k₂.
pub(super) struct Polynomial(pub(super) [f64; 2]);

impl Model for Polynomial {
    const IS_FLAT: bool = true;

    fn name(&self) -> &'static str {
        "polynomial"
    }

    fn coefficients(&self) -> Vec<f64> {
        self.0.to_vec()
    }

    fn calibration_model(&self) -> Option<CalibrationModel> {
        None
    }

    fn reach(&self) -> Reach {
        reach(self.0)
    }

    #[inline]
    fn project(&self, direction: DVec3, reach: &Reach) -> Option<DVec2> {
        distort(self.0, on_plane(direction), reach.radius)
    }

    #[inline]
    fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen> {
        let (ideal, growth) = undistort(self.0, place, reach.radius)?;
        Some(through_plane(ideal, growth))
    }
}

/// Factor 1 + k₁r² + k₂r⁴, and the derivative of r times it.
#[inline]
fn factor([k1, k2]: [f64; 2], r: f64) -> (f64, f64) {
    let r2 = r * r;
    (1.0 + r2 * (k1 + r2 * k2), 1.0 + r2 * (3.0 * k1 + r2 * 5.0 * k2))
}

#[inline]
fn ideal_radius(k: [f64; 2], r: f64) -> (f64, f64) {
    let (factor, slope) = factor(k, r);
    (r * factor, slope)
}

/// Reach of the polynomial: its derivative vanishes where 1 + 3k₁r² + 5k₂r⁴ = 0.
fn reach(k: [f64; 2]) -> Reach {
    let flat = FLAT_ANGLE.tan();
    let [a, b] = [5.0 * k[1], 3.0 * k[0]];
    // Its smallest root above 0 in r², without cancellation; there is none where the parabola stays above 0.
    let under = b * b - 4.0 * a;
    let fold = (under >= 0.0).then(|| -2.0 / (b - under.sqrt())).filter(|r2| *r2 > 0.0 && r2.is_finite());
    let fold = fold.map(f64::sqrt).filter(|r| ideal_radius(k, *r).0 < flat);
    match fold {
        Some(radius) => Reach::new(ideal_radius(k, radius).0.atan(), ReachEnd::Folds, radius),
        None => {
            // As far as the ideal image goes.
            let beyond = first_loss(|r| ideal_radius(k, r).0 < flat, 2.0 * flat, 64);
            Reach::new(FLAT_ANGLE, ReachEnd::Flat, beyond.unwrap_or(2.0 * flat))
        }
    }
}

/// Ideal → distorted within a radius of the distorted image.
#[inline]
fn distort(k: [f64; 2], ideal: DVec2, radius: f64) -> Option<DVec2> {
    let distance = ideal.length();
    if distance == 0.0 {
        return Some(ideal);
    }
    Some(ideal * (solve(|r| ideal_radius(k, r), distance, distance, radius)? / distance))
}

/// Distorted → ideal, and area in the ideal over area in the distorted image.
#[inline]
fn undistort(k: [f64; 2], distorted: DVec2, radius: f64) -> Option<(DVec2, f64)> {
    let r = distorted.length();
    let (factor, slope) = factor(k, r);
    (r <= radius).then_some((distorted * factor, factor * slope))
}
