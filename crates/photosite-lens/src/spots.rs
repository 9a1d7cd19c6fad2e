//! Where the rays of a point land.

use glam::{DVec2, DVec3};

use crate::region::Region;
use crate::trace::{Apertures, LensAt, Ray};

/// Directions in which the edge of a beam is looked for.
const DIRECTIONS: usize = 64;

/// Landing points of rays of equal weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Their mean, mm.
    pub centroid_mm: DVec2,
    /// Root of the mean square of their distance from it, mm.
    pub rms_mm: f64,
    /// How many there are.
    pub rays: usize,
}

impl Spot {
    /// The spot of some landing points; `None` of none.
    pub fn of(points: &[DVec2]) -> Option<Self> {
        if points.is_empty() {
            return None;
        }
        let count = points.len() as f64;
        let centroid_mm = points.iter().sum::<DVec2>() / count;
        let rms_mm = (points.iter().map(|point| point.distance_squared(centroid_mm)).sum::<f64>() / count).sqrt();
        Some(Self { centroid_mm, rms_mm, rays: points.len() })
    }
}

/// The parallel beam of an object at infinity that passes the lens: its rays start in a plane across it.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Direction of its rays, (0, sin θ, cos θ).
    direction: DVec3,
    /// Origin of the plane's coordinates: a point of the chief ray.
    origin: DVec3,
    /// What of the plane passes every aperture; coordinates along x and (0, cos θ, −sin θ), mm.
    pub region: Region,
}

impl Beam {
    /// The ray of a point of the plane.
    pub fn ray(&self, point: DVec2) -> Ray {
        start(self.origin, self.direction, point)
    }
}

fn start(origin: DVec3, direction: DVec3, point: DVec2) -> Ray {
    let up = DVec3::new(0.0, direction.z, -direction.y);
    Ray { origin: origin + DVec3::X * point.x + up * point.y, direction }
}

impl LensAt<'_> {
    /// Where a ray from the scene lands, mm; `None` where it ends inside the lens.
    pub fn landing(&self, ray: Ray, apertures: Apertures) -> Option<DVec2> {
        let behind = self.trace_in(ray, apertures).ok()?;
        let point = behind.at_z(self.lens.sensor_z_mm()).truncate();
        point.is_finite().then_some(point)
    }

    /// The beam of an object at infinity at an angle in rad from the axis; `None` where none of it passes.
    pub fn beam(&self, field_rad: f64) -> Option<Beam> {
        let direction = DVec3::new(0.0, field_rad.sin(), field_rad.cos());
        let first = &self.lens.surfaces()[0];
        // All rays that pass meet the first surface, which lies within this of its vertex.
        let sag = first.profile.sag(first.semi_aperture_mm.powi(2)).unwrap_or(0.0);
        let reach = first.semi_aperture_mm.hypot(sag);
        let vertex = DVec3::ZERO;
        // Before all of the lens, so that rays from the side start before it, too.
        let origin = self.chief_ray(field_rad).map_or(vertex, |chief| chief.before.origin);
        let passes = |point: DVec2| self.trace_in(start(origin, direction, point), Apertures::Clip).is_ok();
        let up = DVec3::new(0.0, direction.z, -direction.y);
        let about = DVec2::new((vertex - origin).x, (vertex - origin).dot(up));
        let region = Region::find(passes, DVec2::ZERO, about, reach, DIRECTIONS)?;
        Some(Beam { direction, origin, region })
    }

    /// Landing points of an object at infinity at an angle in rad from the axis: of those rays of a square grid of
    /// `across`² over the beam that pass every aperture. Empty where none does.
    pub fn spot_diagram(&self, field_rad: f64, across: u32) -> Vec<DVec2> {
        let Some(beam) = self.beam(field_rad) else { return Vec::new() };
        let [low, high] = beam.region.bounds();
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(across);
        let points = (0..across * across).map(|i| low + (high - low) * DVec2::new(at(i % across), at(i / across)));
        points.filter_map(|point| self.landing(beam.ray(point), Apertures::Clip)).collect()
    }
}

/// The modulation that spots alone leave: |Σ exp(−2πi·ν·x)|/n for the frequency ν, cycles per mm, along `axis`, a unit
/// vector.
pub fn geometric_mtf(points: &[DVec2], axis: DVec2, frequency_per_mm: f64) -> f64 {
    let phases =
        points.iter().map(|point| DVec2::from_angle(std::f64::consts::TAU * frequency_per_mm * point.dot(axis)));
    phases.sum::<DVec2>().length() / points.len() as f64
}
