//! The division model, from the distorted to the ideal image: u = u_d/(1 + λr²), r = |u_d|
//! ([Fitzgibbon01](crate::references#fitzgibbon01)). Radii are those of the distorted image.

use glam::{DVec2, DVec3};

use super::CalibrationModel;
use super::model::{Model, Seen};
use super::perspective::{on_plane, through_plane};
use super::reach::{FLAT_ANGLE, Reach, ReachEnd};

/// λ.
pub(super) struct Division(pub(super) f64);

impl Model for Division {
    const IS_FLAT: bool = true;

    fn name(&self) -> &'static str {
        "division"
    }

    fn coefficients(&self) -> Vec<f64> {
        vec![self.0]
    }

    fn calibration_model(&self) -> Option<CalibrationModel> {
        None
    }

    fn reach(&self) -> Reach {
        reach(self.0)
    }

    #[inline]
    fn project(&self, direction: DVec3, _: &Reach) -> Option<DVec2> {
        Some(distort(self.0, on_plane(direction)))
    }

    #[inline]
    fn unproject(&self, place: DVec2, reach: &Reach) -> Option<Seen> {
        let (ideal, growth) = undistort(self.0, place, reach.radius)?;
        Some(through_plane(ideal, growth))
    }
}

/// Reach: a barrel (λ < 0) shows 90° at r = 1/√−λ; a pincushion folds at r = 1/√λ, where the ideal radius is 1/(2√λ).
fn reach(lambda: f64) -> Reach {
    let flat = FLAT_ANGLE.tan();
    if lambda > 0.0 && 0.5 / lambda.sqrt() < flat {
        let radius = 1.0 / lambda.sqrt();
        return Reach::new((0.5 * radius).atan(), ReachEnd::Folds, radius);
    }
    Reach::new(FLAT_ANGLE, ReachEnd::Flat, distort(lambda, DVec2::X * flat).x)
}

/// Ideal → distorted: r_d = 2r/(1 + √(1 − 4λr²)).
#[inline]
fn distort(lambda: f64, ideal: DVec2) -> DVec2 {
    ideal * (2.0 / (1.0 + (1.0 - 4.0 * lambda * ideal.length_squared()).max(0.0).sqrt()))
}

/// Distorted → ideal, and area in the ideal over area in the distorted image: (1 − λr²)/(1 + λr²)³.
#[inline]
fn undistort(lambda: f64, distorted: DVec2, radius: f64) -> Option<(DVec2, f64)> {
    let r2 = distorted.length_squared();
    let under = 1.0 + lambda * r2;
    (r2.sqrt() <= radius).then(|| (distorted / under, (1.0 - lambda * r2) / (under * under * under)))
}
