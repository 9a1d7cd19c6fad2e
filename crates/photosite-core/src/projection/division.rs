//! The division model, from the distorted to the ideal picture: u = u_d/(1 + λr²), r = |u_d|
//! ([Fitzgibbon01](crate::references#fitzgibbon01)). Radii are those of the distorted picture.

use glam::DVec2;

use super::{FLAT_ANGLE, Reach, ReachEnd};

/// A barrel (λ < 0) shows 90° at r = 1/√−λ; a pincushion folds at r = 1/√λ, where the ideal radius is 1/(2√λ).
pub(super) fn reach(lambda: f64) -> Reach {
    let flat = FLAT_ANGLE.tan();
    if lambda > 0.0 && 0.5 / lambda.sqrt() < flat {
        let radius = 1.0 / lambda.sqrt();
        return Reach::new((0.5 * radius).atan(), ReachEnd::Folds, radius);
    }
    Reach::new(FLAT_ANGLE, ReachEnd::Flat, distort(lambda, DVec2::X * flat).x)
}

/// Ideal → distorted: r_d = 2r/(1 + √(1 − 4λr²)).
#[inline]
pub(super) fn distort(lambda: f64, ideal: DVec2) -> DVec2 {
    ideal * (2.0 / (1.0 + (1.0 - 4.0 * lambda * ideal.length_squared()).max(0.0).sqrt()))
}

/// Distorted → ideal, and area in the ideal over area in the distorted picture: (1 − λr²)/(1 + λr²)³.
#[inline]
pub(super) fn undistort(lambda: f64, distorted: DVec2, radius: f64) -> Option<(DVec2, f64)> {
    let r2 = distorted.length_squared();
    let under = 1.0 + lambda * r2;
    (r2.sqrt() <= radius).then(|| (distorted / under, (1.0 - lambda * r2) / (under * under * under)))
}
