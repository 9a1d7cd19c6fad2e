//! Equirectangular panoramas: x is the longitude atan2(X, Z), y the latitude below the horizon asin(Y), in radians.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use super::CalibrationModel;
use super::model::{Model, Seen};
use super::reach::{Reach, ReachEnd};

/// The model, which has no coefficients.
pub(super) struct Equirectangular;

impl Model for Equirectangular {
    const IS_FLAT: bool = false;

    fn name(&self) -> &'static str {
        "equirectangular"
    }

    fn coefficients(&self) -> Vec<f64> {
        Vec::new()
    }

    fn calibration_model(&self) -> Option<CalibrationModel> {
        None
    }

    fn reach(&self) -> Reach {
        Reach::new(PI, ReachEnd::Sees, PI)
    }

    #[inline]
    fn project(&self, direction: DVec3, _: &Reach) -> Option<DVec2> {
        Some(project(direction))
    }

    #[inline]
    fn unproject(&self, place: DVec2, _: &Reach) -> Option<Seen> {
        unproject(place)
    }
}

#[inline]
fn project(direction: DVec3) -> DVec2 {
    let DVec3 { x, y, z } = direction;
    DVec2::new(x.atan2(z), y.atan2(x.hypot(z)))
}

/// dΩ/dA is the cosine of the latitude. Places beyond the poles or the meridian behind see nothing.
#[inline]
fn unproject(place: DVec2) -> Option<Seen> {
    let (sin_x, cos_x) = place.x.sin_cos();
    let (sin_y, cos_y) = place.y.sin_cos();
    let direction = DVec3::new(cos_y * sin_x, sin_y, cos_y * cos_x);
    (place.x.abs() <= PI && place.y.abs() <= FRAC_PI_2).then(|| Seen::all_round(direction, cos_y))
}
