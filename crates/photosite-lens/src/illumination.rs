//! Illumination of the sensor by a lens: the region of directions that pass.
//!
//! The irradiance at a sensor point is E = ∫ L·cos θ dω = ∬ L dp dq over the region S of direction cosines (p, q) that
//! pass every aperture: no cos⁴ and no Jacobian ([Kolb95](photosite_core::references#kolb95),
//! [Pbrt4](photosite_core::references#pbrt4) §5.4.1). In a scene of uniform radiance L it is L·|S|.

use glam::{DVec2, DVec3};

use crate::profile::Travel;
use crate::region::Region;
use crate::trace::{Apertures, LensAt, Ray};

impl LensAt<'_> {
    /// Ray from a sensor point, mm from the axis, with the direction cosines (p, q) out into the scene; the length of
    /// (p, q) is at most 1.
    pub fn ray_from_sensor(&self, point: DVec2, cosines: DVec2) -> Ray {
        let z = -(1.0 - cosines.length_squared()).max(0.0).sqrt();
        Ray { origin: point.extend(self.lens.sensor_z_mm()), direction: DVec3::new(cosines.x, cosines.y, z) }
    }

    /// Whether the ray from a sensor point with some direction cosines passes every aperture.
    pub fn passes(&self, point: DVec2, cosines: DVec2) -> bool {
        cosines.length_squared() < 1.0 && self.trace_out(self.ray_from_sensor(point, cosines), Apertures::Clip).is_ok()
    }

    /// Region S of direction cosines in which rays from the sensor point (0, h) pass, given by its boundary in
    /// `directions` directions; its area is in sr. `None` where no ray passes.
    pub fn pupil_region(&self, image_height_mm: f64, directions: usize) -> Option<Region> {
        let point = DVec2::new(0.0, image_height_mm);
        let (about, reach) = self.rear_opening(image_height_mm);
        let chief = self.chief_ray_at_height(image_height_mm);
        let seed = chief.map_or(about, |chief| -chief.behind.direction.truncate());
        let depth = |cosines: DVec2| {
            if cosines.length_squared() < 1.0 {
                self.margin(self.ray_from_sensor(point, cosines), Travel::ToScene)
            } else {
                f64::NEG_INFINITY
            }
        };
        Region::find(depth, seed, about, reach, directions)
    }

    /// Circle of direction cosines, centre and radius, that contains all rays from the sensor point (0, h) to the last
    /// surface.
    pub(crate) fn rear_opening(&self, image_height_mm: f64) -> (DVec2, f64) {
        let last = self.lens.surfaces().last().expect("a lens has surfaces");
        let semi = last.semi_aperture_mm;
        // Over the surface, from its vertex to its rim.
        let sag = last.profile.sag(semi * semi).unwrap_or(0.0);
        let cosines = |x: f64, y: f64, z: f64| {
            DVec3::new(x, y - image_height_mm, z - self.lens.sensor_z_mm()).normalize().truncate()
        };
        let depths = [last.z_mm, last.z_mm + sag];
        let rim = |i: u32| {
            let (y, x) = (std::f64::consts::TAU * f64::from(i) / 64.0).sin_cos();
            depths.map(|z| cosines(semi * x, semi * y, z))
        };
        let all: Vec<DVec2> = (0..64).flat_map(rim).collect();
        let [low, high] = all
            .iter()
            .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], point| [low.min(*point), high.max(*point)]);
        let about = 0.5 * (low + high);
        let reach = all.iter().map(|point| point.distance(about)).fold(0.0, f64::max);
        // Between 64 points of a convex rim the circle may bulge by 1 − cos(π/64).
        (about, 1.01 * reach)
    }
}
