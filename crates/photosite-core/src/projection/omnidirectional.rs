//! The unified model of mirrors and fisheyes ([MeiRives07](crate::references#meirives07)): the unit direction, moved by
//! ξ along the axis, through a pinhole: (X, Y)/(Z + ξ). Radii of a reach are measured before the distortion.

use glam::{DVec2, DVec3};

use super::model::{Model, Seen};
use super::reach::{FLAT_ANGLE, Reach, ReachEnd};
use super::{BrownConrady, CalibrationModel};

/// ξ, and the distortion behind the mirror.
pub(super) struct Omnidirectional<'a> {
    pub(super) xi: f64,
    pub(super) distortion: &'a BrownConrady,
}

impl Model for Omnidirectional<'_> {
    const IS_FLAT: bool = false;

    fn name(&self) -> &'static str {
        "omnidirectional"
    }

    fn coefficients(&self) -> Vec<f64> {
        let BrownConrady { k: [k1, k2, ..], p: [p1, p2], .. } = *self.distortion;
        vec![k1, k2, p1, p2]
    }

    fn xi(&self) -> Option<f64> {
        Some(self.xi)
    }

    fn calibration_model(&self) -> Option<CalibrationModel> {
        Some(CalibrationModel::Omnidirectional { xi: self.xi, distortion: *self.distortion })
    }

    fn reach(&self) -> Reach {
        reach(self.xi, self.distortion)
    }

    #[inline]
    fn project(&self, direction: DVec3, _: &Reach) -> Option<DVec2> {
        Some(self.distortion.distort(project(self.xi, direction)))
    }

    #[inline]
    fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen> {
        let (ideal, growth) = self.distortion.undistort(place, reach.radius)?;
        let seen = unproject(self.xi, ideal)?;
        Some(Seen { solid_angle: seen.solid_angle / growth, ..seen })
    }
}

/// Reach of a mirror: the image grows until cos θ = −ξ, where it is infinitely large (ξ ≤ 1), or cos θ = −1/ξ, where it
/// turns back (ξ > 1), the rim of the mirror.
fn reach(xi: f64, distortion: &BrownConrady) -> Reach {
    let largest = FLAT_ANGLE.tan();
    let rim = if xi > 1.0 { 1.0 / (xi * xi - 1.0).sqrt() } else { largest };
    let folds = distortion.fold().filter(|fold| *fold < rim);
    let radius = folds.unwrap_or(rim.min(largest));
    let end = if folds.is_some() { ReachEnd::Folds } else { ReachEnd::Sees };
    let angle = match unproject(xi, DVec2::X * radius) {
        Some(seen) => seen.direction.x.atan2(seen.direction.z),
        None => (-1.0 / xi).acos(),
    };
    Reach::new(angle, end, radius)
}

#[inline]
fn project(xi: f64, direction: DVec3) -> DVec2 {
    DVec2::new(direction.x, direction.y) / (direction.z + xi * direction.length())
}

/// Direction and solid angle: the point of the sphere is α·(x, y, 1) − (0, 0, ξ) with α = (ξ + √(1 + (1 − ξ²)r²))/(1 +
/// r²). With r = sin θ/(cos θ + ξ), dΩ/dA = sin θ/(r·dr/dθ) = (cos θ + ξ)³/(1 + ξ·cos θ).
#[inline]
fn unproject(xi: f64, place: DVec2) -> Option<Seen> {
    let r2 = place.length_squared();
    let under = 1.0 + (1.0 - xi * xi) * r2;
    if under < 0.0 {
        return None;
    }
    let alpha = (xi + under.sqrt()) / (1.0 + r2);
    let cos = alpha - xi;
    Some(Seen::all_round((place * alpha).extend(cos), alpha.powi(3) / (1.0 + xi * cos)))
}
