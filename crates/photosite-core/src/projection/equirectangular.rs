//! Panoramas: x is the longitude atan2(X, Z), y the latitude below the horizon asin(Y), in radians.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use super::Seen;

#[inline]
pub(super) fn project(direction: DVec3) -> DVec2 {
    let DVec3 { x, y, z } = direction;
    DVec2::new(x.atan2(z), y.atan2(x.hypot(z)))
}

/// dΩ/dA is the cosine of the latitude. Beyond the poles and the meridian behind there is nothing.
#[inline]
pub(super) fn unproject(place: DVec2) -> Option<Seen> {
    let (sin_x, cos_x) = place.x.sin_cos();
    let (sin_y, cos_y) = place.y.sin_cos();
    let direction = DVec3::new(cos_y * sin_x, sin_y, cos_y * cos_x);
    (place.x.abs() <= PI && place.y.abs() <= FRAC_PI_2).then(|| Seen::all_round(direction, cos_y))
}
