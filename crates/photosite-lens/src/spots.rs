//! Spot diagrams: landing points of the rays of an object point.

use glam::{DVec2, DVec3};

use crate::chief::ChiefRay;
use crate::profile::Travel;
use crate::region::Region;
use crate::trace::{Apertures, LensAt, Ray};

/// Number of directions in which the edge of a beam is searched for.
const DIRECTIONS: usize = 64;

/// Statistics of landing points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Mean of the landing points, mm.
    pub centroid_mm: DVec2,
    /// Root mean square distance from the centroid, mm.
    pub rms_mm: f64,
    /// Number of rays.
    pub rays: usize,
}

impl Spot {
    /// Spot of landing points with their weights; `None` of no points.
    pub fn of(points: &[(DVec2, f64)]) -> Option<Self> {
        let total: f64 = points.iter().map(|(_, weight)| weight).sum();
        if points.is_empty() {
            return None;
        }
        let centroid_mm = points.iter().map(|(point, weight)| *point * *weight).sum::<DVec2>() / total;
        let square = |(point, weight): &(DVec2, f64)| point.distance_squared(centroid_mm) * weight;
        let rms_mm = (points.iter().map(square).sum::<f64>() / total).sqrt();
        Some(Self { centroid_mm, rms_mm, rays: points.len() })
    }
}

/// A point of the scene on a line into the lens.
#[derive(Clone, Copy, Debug)]
pub struct ObjectPoint {
    /// Point of the line, mm.
    pub origin: DVec3,
    /// Direction of the line into the lens, (0, sin θ, cos θ).
    pub direction: DVec3,
    /// Distance of the object from there back along the line, mm; infinite for parallel light, below 0 for light that
    /// converges behind the point.
    pub distance_mm: f64,
}

impl ObjectPoint {
    /// Object point on a chief ray, at a distance from that ray's point on the first surface, mm.
    pub fn on(chief: &ChiefRay, distance_mm: f64) -> Self {
        let Ray { origin, direction } = chief.before;
        Self { origin, direction, distance_mm }
    }

    /// Unit vectors across the line.
    pub(crate) fn across(&self) -> [DVec3; 2] {
        [DVec3::X, DVec3::new(0.0, self.direction.z, -self.direction.y)]
    }

    /// Ray of the object point through a point of the plane across the line, mm.
    pub fn ray(&self, point: DVec2) -> Ray {
        let [x, y] = self.across();
        let offset = x * point.x + y * point.y;
        let towards = self.direction + offset / self.distance_mm;
        Ray { origin: self.origin + offset, direction: towards.normalize() }
    }

    /// Projection of a place onto that plane as seen from the object point, mm.
    fn place(&self, place: DVec3) -> DVec2 {
        let from = place - self.origin;
        let [x, y] = self.across().map(|axis| from.dot(axis));
        DVec2::new(x, y) / (1.0 + from.dot(self.direction) / self.distance_mm)
    }

    /// Flux of the object point per area of that plane, relative to the middle.
    fn flux(&self, point: DVec2) -> f64 {
        (1.0 + (point / self.distance_mm).length_squared()).powf(-1.5)
    }
}

/// Beam of an object point that passes a lens.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Object point.
    pub object: ObjectPoint,
    /// Region of the plane across the object's line that passes every aperture, mm.
    pub region: Region,
}

impl Beam {
    /// Ray through a point of the plane.
    pub fn ray(&self, point: DVec2) -> Ray {
        self.object.ray(point)
    }
}

impl LensAt<'_> {
    /// Landing point of a ray from the scene, mm; `None` where it ends inside the lens.
    pub fn landing(&self, ray: Ray, apertures: Apertures) -> Option<DVec2> {
        let behind = self.trace_in(ray, apertures).ok()?;
        let point = behind.at_z(self.lens.sensor_z_mm()).truncate();
        point.is_finite().then_some(point)
    }

    /// Beam of an object at infinity at an angle in rad from the axis; `None` where none of it passes.
    pub fn beam(&self, field_rad: f64) -> Option<Beam> {
        // Before all of the lens, so that rays from the side start before it, too.
        let origin = self.chief_ray(field_rad).map_or(DVec3::ZERO, |chief| chief.before.origin);
        let direction = DVec3::new(0.0, field_rad.sin(), field_rad.cos());
        self.beam_of(ObjectPoint { origin, direction, distance_mm: f64::INFINITY }, DIRECTIONS)
    }

    /// Beam of an object point, with its edge in this number of directions; `None` where none of it passes.
    pub fn beam_of(&self, object: ObjectPoint, directions: usize) -> Option<Beam> {
        let first = &self.lens.surfaces()[0];
        // All rays that pass meet the first surface, which lies within this of its vertex.
        let sag = first.profile.sag(first.semi_aperture_mm.powi(2)).unwrap_or(0.0);
        let reach = first.semi_aperture_mm.hypot(sag);
        // As the point sees it: what is nearer looks larger.
        let nearest = (1.0 - 2.0 * reach / object.distance_mm.abs()).max(0.1);
        let depth = |point: DVec2| self.margin(object.ray(point), Travel::ToSensor);
        let region = Region::find(depth, DVec2::ZERO, object.place(DVec3::ZERO), reach / nearest, directions)?;
        Some(Beam { object, region })
    }

    /// Landing points of the light of a point, mm, with weights: over all light that passes every aperture, by
    /// quadrature. Empty where nothing passes.
    pub fn spot(&self, object: ObjectPoint, directions: usize) -> Vec<(DVec2, f64)> {
        let Some(beam) = self.beam_of(object, directions) else { return Vec::new() };
        let landing =
            |(point, area)| Some((self.landing(beam.ray(point), Apertures::Ignore)?, area * object.flux(point)));
        beam.region.points().filter_map(landing).collect()
    }

    /// Landing points for a spot diagram, mm: those rays of a square grid of `across`² over the beam that pass every
    /// aperture. Empty where none does.
    pub fn spot_diagram(&self, object: ObjectPoint, across: u32) -> Vec<DVec2> {
        let Some(beam) = self.beam_of(object, DIRECTIONS) else { return Vec::new() };
        let [low, high] = beam.region.bounds();
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(across);
        let points = (0..across * across).map(|i| low + (high - low) * DVec2::new(at(i % across), at(i / across)));
        points.filter_map(|point| self.landing(beam.ray(point), Apertures::Clip)).collect()
    }
}

/// Geometric modulation transfer function: |Σ w·exp(−2πi·ν·x)|/Σ w for the frequency ν, cycles per mm, along `axis`, a
/// unit vector.
pub fn geometric_mtf(points: &[(DVec2, f64)], axis: DVec2, frequency_per_mm: f64) -> f64 {
    let phase = |point: DVec2| DVec2::from_angle(std::f64::consts::TAU * frequency_per_mm * point.dot(axis));
    let sum: DVec2 = points.iter().map(|(point, weight)| phase(*point) * *weight).sum();
    sum.length() / points.iter().map(|(_, weight)| weight).sum::<f64>()
}
