//! The unified model of mirrors and fisheyes ([MeiRives07](crate::references#meirives07)): the unit direction, moved by ξ
//! along the axis, through a pinhole: (X, Y)/(Z + ξ). Radii of a reach are those of that picture, before its distortion.

use glam::{DVec2, DVec3};

use super::{BrownConrady, FLAT_ANGLE, Reach, ReachEnd, Seen};

/// The picture grows until cos θ = −ξ, where it is infinitely large (ξ ≤ 1), or cos θ = −1/ξ, where it turns back
/// (ξ > 1): the rim of the mirror.
pub(super) fn reach(xi: f64, distortion: &BrownConrady) -> Reach {
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
pub(super) fn project(xi: f64, direction: DVec3) -> DVec2 {
    DVec2::new(direction.x, direction.y) / (direction.z + xi * direction.length())
}

/// The point of the sphere is α·(x, y, 1) − (0, 0, ξ) with α = (ξ + √(1 + (1 − ξ²)r²))/(1 + r²). With
/// r = sin θ/(cos θ + ξ), dΩ/dA = sin θ/(r·dr/dθ) = (cos θ + ξ)³/(1 + ξ·cos θ).
#[inline]
pub(super) fn unproject(xi: f64, place: DVec2) -> Option<Seen> {
    let r2 = place.length_squared();
    let under = 1.0 + (1.0 - xi * xi) * r2;
    if under < 0.0 {
        return None;
    }
    let alpha = (xi + under.sqrt()) / (1.0 + r2);
    let cos = alpha - xi;
    Some(Seen::all_round((place * alpha).extend(cos), alpha.powi(3) / (1.0 + xi * cos)))
}
