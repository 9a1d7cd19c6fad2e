//! Rings that cut off part of the light beside the aperture: mechanical vignetting, and the cat's eyes of blurred
//! lights.

use glam::{DVec2, DVec3};

/// Stop: a round opening across the axis, centred on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Distance before the lens, m; below 0 behind it, as far as the sensor.
    pub distance_m: f64,
    /// Radius, m.
    pub radius_m: f64,
}

impl Stop {
    /// Whether light passes that comes along `direction` (camera space, from the lens outwards) through a point of the
    /// lens to a point of the sensor, `image_distance_m` behind it.
    ///
    /// With the lens's radius R, and parallel light at an angle α, what passes is the overlap of two circles of radii R
    /// and r whose centres are d·tan α apart.
    #[inline]
    pub(super) fn passes(&self, opening: DVec2, direction: DVec3, sensor: DVec2, image_distance_m: f64) -> bool {
        let at = if self.distance_m >= 0.0 {
            opening + DVec2::new(direction.x, direction.y) * (self.distance_m / -direction.z)
        } else {
            opening.lerp(sensor, -self.distance_m / image_distance_m)
        };
        at.length_squared() <= self.radius_m * self.radius_m
    }
}
