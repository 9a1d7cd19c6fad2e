//! Kannala–Brandt fisheyes: the image radius is d(θ) = θ + k₁θ³ + k₂θ⁵ + k₃θ⁷ + k₄θ⁹ for an angle θ from the axis
//! ([KannalaBrandt06](crate::references#kannalabrandt06), with the first coefficient 1 as in OpenCV). Radii of a reach
//! are angles.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::CalibrationModel;
use super::model::{Model, Seen};
use super::reach::{Reach, ReachEnd};
use super::rising::{first_loss, solve};

/// k₁ … k₄.
pub(super) struct KannalaBrandt(pub(super) [f64; 4]);

impl Model for KannalaBrandt {
    const IS_FLAT: bool = false;

    fn name(&self) -> &'static str {
        "kannala-brandt"
    }

    fn coefficients(&self) -> Vec<f64> {
        self.0.to_vec()
    }

    fn calibration_model(&self) -> Option<CalibrationModel> {
        Some(CalibrationModel::KannalaBrandt { k: self.0 })
    }

    fn reach(&self) -> Reach {
        reach(self.0)
    }

    #[inline]
    fn project(&self, direction: DVec3, _: &Reach) -> Option<DVec2> {
        Some(project(self.0, direction))
    }

    #[inline]
    fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen> {
        unproject(self.0, place, reach.radius)
    }
}

/// d and its derivative.
#[inline]
fn radius([k1, k2, k3, k4]: [f64; 4], theta: f64) -> (f64, f64) {
    let t2 = theta * theta;
    let value = 1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4)));
    let slope = 1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4)));
    (theta * value, slope)
}

fn reach(k: [f64; 4]) -> Reach {
    match first_loss(|theta| radius(k, theta).1 > 0.0, PI, 8192) {
        Some(angle) => Reach::new(angle, ReachEnd::Folds, angle),
        None => Reach::new(PI, ReachEnd::Sees, PI),
    }
}

#[inline]
fn project(k: [f64; 4], direction: DVec3) -> DVec2 {
    let across = DVec2::new(direction.x, direction.y);
    let sin = across.length();
    let theta = sin.atan2(direction.z);
    // On the axis d/sin → 1/z.
    if sin == 0.0 { across } else { across * (radius(k, theta).0 / sin) }
}

/// Solid angle: dΩ = sin θ dθ dφ and dA = d·dd·dφ, so dΩ/dA = sin θ/(d·d').
#[inline]
fn unproject(k: [f64; 4], place: DVec2, largest_angle: f64) -> Option<Seen> {
    let distance = place.length();
    if distance == 0.0 {
        return Some(Seen::all_round(DVec3::Z, 1.0));
    }
    let theta = solve(|theta| radius(k, theta), distance, distance, largest_angle)?;
    let (sin, cos) = theta.sin_cos();
    let direction = (place * (sin / distance)).extend(cos);
    Some(Seen::all_round(direction, sin / (distance * radius(k, theta).1)))
}
