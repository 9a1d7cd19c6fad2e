//! Connection of a point of the scene to the pixel that sees it, for paths that come from lights.

use glam::{DQuat, DVec2, DVec3, Vec3};

use super::Camera;
use super::ray::{Aim, CameraRay};
use crate::geometry::Ray;
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

/// Connection of a point in the world to the sensor, through a point of the aperture.
#[derive(Clone, Copy, Debug)]
pub struct Connection {
    /// Continuous pixel coordinates, on the sensor or beside it.
    pub pixel: DVec2,
    /// Ray from the lens by the point; see [`Camera::generate`].
    pub ray: CameraRay,
    /// Weight of each wavelength.
    pub weights: SampledSpectrum,
    /// Area of the image over that of what it shows on a plane across the ray at the point, px²·m⁻².
    pub px2_per_m2: f32,
}

impl Camera {
    /// Finds the pixel position whose ray goes by a point in world space, of the same samples as
    /// [`Self::generate_spectral`] takes: its inverse, found by Newton's method, since neither distortion nor an
    /// entrance pupil that turns has one in closed form. `None` where the lens does not see the point. Of a camera that
    /// stands still, with another lens than a prescription, whose rays it does not find.
    pub fn connect(
        &self,
        point: Vec3,
        aperture_sample: [f32; 2],
        spread_sample: [f32; 2],
        wavelengths: &mut Wavelengths,
    ) -> Option<Connection> {
        /// Width of finite differences, px: as exact as an f64 makes them of functions that are smooth over pixels.
        const STEP_PX: f64 = 0.01;
        const NEAR_PX: f64 = 1e-4;
        const MOST_STEPS: u32 = 8;
        if self.prescribed.is_some() {
            return None;
        }
        if self.parts_wavelengths() {
            wavelengths.terminate_secondary();
        }
        let focus_distance_m = self.focus_of(wavelengths);
        let opening = self.opening(aperture_sample);
        let point = self.to_world.inverse().transform_point3(point.as_dvec3());
        let aim = |pixel| self.aim(self.spread_place(pixel, spread_sample, wavelengths).0, opening, focus_distance_m);
        let across = DQuat::from_rotation_arc(DVec3::Z, point.try_normalize()?);
        let (right, up, forward) = (across * DVec3::X, across * DVec3::Y, across * DVec3::Z);
        // Where the ray of a pixel position meets the plane across the direction of the point, seen from the point.
        let miss = |pixel: DVec2| -> Option<DVec2> {
            let Aim { origin, towards, .. } = aim(pixel)?;
            let t = (point - origin).dot(forward) / towards.dot(forward);
            let miss = origin + towards * t - point;
            (t > 0.0).then(|| DVec2::new(miss.dot(right), miss.dot(up)))
        };
        let mut pixel = self.project_camera(point)?;
        for _ in 0..MOST_STEPS {
            let here = miss(pixel)?;
            let along = |step: DVec2| Some((miss(pixel + step)? - miss(pixel - step)?) / (2.0 * STEP_PX));
            let (by_x, by_y) = (along(DVec2::X * STEP_PX)?, along(DVec2::Y * STEP_PX)?);
            let m2_per_px2 = by_x.perp_dot(by_y);
            let step = DVec2::new(by_y.perp_dot(here), here.perp_dot(by_x)) / m2_per_px2;
            pixel += step;
            if step.length_squared() > NEAR_PX * NEAR_PX {
                continue;
            }
            let found = aim(pixel)?;
            if !self.passes(found.seen.chief, opening, found.towards) {
                return None;
            }
            let direction = found.towards.normalize();
            let origin = self.to_world.transform_point3(found.origin).as_vec3();
            let ray = Ray::new(origin, self.to_world.transform_vector3(direction).as_vec3()).at_time(self.time);
            let (_, weights) = self.spread_place(pixel, spread_sample, wavelengths);
            // The plane is across the line to the lens's centre; what is seen of it is across the ray.
            let tilt = direction.dot(forward).abs();
            return Some(Connection {
                pixel,
                ray: CameraRay { ray, weight: self.weight(&found, opening) },
                weights,
                px2_per_m2: (1.0 / (m2_per_px2.abs() * tilt)) as f32,
            });
        }
        None
    }
}
