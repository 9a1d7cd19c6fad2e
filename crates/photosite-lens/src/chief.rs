//! Chief rays, through the centre of the stop, whatever apertures cut off.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::profile::Travel;
use crate::trace::{Apertures, LensAt, Ray, Step, Stopped};

/// Number of angles at the stop, from the axis to 90°, that bracket the wanted ray.
const ANGLES: u32 = 256;
/// Number of bisections of the bracket, after which no digit is left.
const HALVINGS: u32 = 60;
/// Largest deviation of the found ray from the wanted value, mm or rad; it is far smaller unless the lens has no such
/// ray.
const TOLERANCE: f64 = 1e-9;

/// A chief ray in the y–z plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiefRay {
    /// Ray before the lens, towards the sensor, from its point on the first surface.
    pub before: Ray,
    /// Ray behind the lens, towards the sensor, from its point on the last surface.
    pub behind: Ray,
    /// Angle to the axis before the lens, rad: that of the direction (0, sin θ, cos θ); above π/2 for objects behind
    /// the first vertex.
    pub field_rad: f64,
    /// Angle to the axis at the stop, in the medium before it, rad.
    pub stop_rad: f64,
    /// Image height: distance from the axis at which the ray meets the sensor, mm.
    pub image_height_mm: f64,
}

impl ChiefRay {
    /// Entrance pupil of the field: the point at which the ray crosses the axis before the lens, mm from the first
    /// vertex. NaN on the axis itself.
    pub fn entrance_pupil_mm(&self) -> f64 {
        let Ray { origin, direction } = self.before;
        origin.z - origin.y / direction.y * direction.z
    }

    /// Object height: distance from the axis, mm, in the plane `distance_mm` before the first vertex.
    pub fn object_height_mm(&self, distance_mm: f64) -> f64 {
        self.before.at_z(-distance_mm).y
    }

    /// Distortion of a field angle θ, 100·(h/(f·tan θ) − 1) in per cent, with the focal length f of the wavelength. NaN
    /// on the axis.
    pub fn distortion_percent(&self, efl_mm: f64) -> f64 {
        100.0 * (self.image_height_mm / (efl_mm * self.field_rad.tan()) - 1.0)
    }
}

impl LensAt<'_> {
    /// The chief ray that reaches the stop at an angle in rad to the axis, in the medium before the stop, traced from
    /// there both ways.
    pub fn chief_ray_of_stop_angle(&self, angle_rad: f64) -> Result<ChiefRay, Stopped> {
        let (stop, surfaces) = (self.lens.stop(), self.lens.surfaces().len());
        let origin = DVec3::new(0.0, 0.0, self.lens.surfaces()[stop].z_mm);
        let direction = DVec3::new(0.0, angle_rad.sin(), angle_rad.cos());
        let through = |ray, travel, steps: &mut dyn Iterator<Item = Step>| {
            self.trace(ray, travel, steps, Apertures::Ignore, |_| {})
        };
        let outwards = Ray { origin, direction: -direction };
        let before = through(outwards, Travel::ToScene, &mut (0..stop).rev().map(Step::refract))?.reversed();
        let behind = through(Ray { origin, direction }, Travel::ToSensor, &mut (stop..surfaces).map(Step::refract))?;
        Ok(ChiefRay {
            before,
            behind,
            stop_rad: angle_rad,
            field_rad: before.direction.y.atan2(before.direction.z),
            image_height_mm: behind.at_z(self.lens.sensor_z_mm()).y,
        })
    }

    /// Whether the chief ray at an angle at the stop, rad, passes every aperture. Far from the axis of a lens that
    /// vignettes, it does not, and light reaches the image beside the stop's centre.
    pub fn chief_ray_passes(&self, angle_rad: f64) -> bool {
        let stop = self.lens.stop();
        let origin = DVec3::new(0.0, 0.0, self.lens.surfaces()[stop].z_mm);
        let direction = DVec3::new(0.0, angle_rad.sin(), angle_rad.cos());
        let outwards = Ray { origin, direction: -direction };
        let before = (0..stop).rev().map(Step::refract);
        let behind = (stop..self.lens.surfaces().len()).map(Step::refract);
        self.trace(outwards, Travel::ToScene, before, Apertures::Clip, |_| {}).is_ok()
            && self.trace(Ray { origin, direction }, Travel::ToSensor, behind, Apertures::Clip, |_| {}).is_ok()
    }

    /// Image height in mm up to which chief rays pass every aperture, searched up to an angle at the stop in rad;
    /// infinite where all pass.
    pub fn clear_height_mm(&self, end: f64) -> f64 {
        let at = |i: u32| end * f64::from(i) / f64::from(ANGLES);
        let Some(blocked) = (1..=ANGLES).find(|&i| !self.chief_ray_passes(at(i))) else { return f64::INFINITY };
        let (mut low, mut high) = (at(blocked - 1), at(blocked));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.chief_ray_passes(middle) { low = middle } else { high = middle }
        }
        self.chief_ray_of_stop_angle(low).map_or(0.0, |chief| chief.image_height_mm.abs())
    }

    /// The chief ray of an object at infinity at an angle in rad from the axis; `None` where the lens has none.
    pub fn chief_ray(&self, field_rad: f64) -> Option<ChiefRay> {
        self.find_chief_ray(field_rad, |chief| chief.field_rad)
    }

    /// The chief ray that meets the sensor at a height in mm; `None` where none does.
    pub fn chief_ray_at_height(&self, image_height_mm: f64) -> Option<ChiefRay> {
        self.find_chief_ray(image_height_mm, |chief| chief.image_height_mm)
    }

    /// The chief ray of a point at a height, mm, in the plane `distance_mm` before the first vertex; `None` where the
    /// lens has none.
    pub fn chief_ray_of_object(&self, height_mm: f64, distance_mm: f64) -> Option<ChiefRay> {
        self.find_chief_ray(height_mm, |chief| chief.object_height_mm(distance_mm))
    }

    /// The chief ray nearest to the axis for which a quantity, 0 on the axis, has this value.
    fn find_chief_ray(&self, value: f64, quantity: impl Fn(&ChiefRay) -> f64) -> Option<ChiefRay> {
        let at = |angle: f64| self.chief_ray_of_stop_angle(angle).ok();
        let step = FRAC_PI_2 / f64::from(ANGLES);
        // Where something before the stop makes an image of its own, the stop is seen upside down.
        let side = (quantity(&at(step)?) * value).signum();
        let reaches = |angle: f64| at(side * angle).is_none_or(|chief| quantity(&chief).abs() >= value.abs());
        let beyond = (0..ANGLES).find(|i| reaches(f64::from(i + 1) * step))?;
        let (mut low, mut high) = (f64::from(beyond) * step, f64::from(beyond + 1) * step);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if reaches(middle) { high = middle } else { low = middle }
        }
        at(side * low).filter(|chief| (quantity(chief) - value).abs() < TOLERANCE * value.abs().max(1.0))
    }
}
