//! Spheres, sampled evenly by solid angle: from outside the cone that they subtend
//! ([pbrt4](photosite_core::references#pbrt4) §6.2.4), from inside all directions. From outside that is their front, and
//! from inside their back, so that a sphere never hides its own sample.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::Vec3;

use super::{EmitterPoint, EmitterShape, SeenPoint};
use crate::geometry::Sphere;
use photosite_core::math::float::gamma;
use photosite_core::math::{Cone, Frame, Pdf, SolidAngle, warp};

/// A sphere as it is seen from a point.
struct View {
    /// Unit vector away from the centre.
    away: Vec3,
    /// Distance from the centre, m.
    distance: f32,
    /// Difference between the squares of that distance and of the radius, m².
    beyond: f32,
    /// Height of the cone, 1 − cos of the half-angle of the directions that meet it; 2 of all.
    height: f32,
}

impl View {
    /// View of the sphere from a point; `None` from the surface itself, within its rounding: what is seen of the sphere
    /// from there is beyond the horizon or across, and no direction is near to both.
    #[inline]
    fn new(sphere: &Sphere, from: Vec3) -> Option<Self> {
        let from_centre = from - sphere.centre;
        let distance = from_centre.length();
        let outside = distance - sphere.radius;
        if outside.abs() <= (sphere.centre.abs().max_element() + sphere.radius) * gamma(16) {
            return None;
        }
        let beyond = outside * (distance + sphere.radius);
        let sin = sphere.radius / distance;
        // 1 − cos = sin²/(1 + cos) keeps the digits of spheres that are small for their distance.
        let height = if outside > 0.0 { sin * sin / (1.0 + beyond.sqrt() / distance) } else { 2.0 };
        let away = if distance > 0.0 { from_centre / distance } else { Vec3::Z };
        Some(Self { away, distance, beyond, height })
    }

    #[inline]
    fn is_inside(&self) -> bool {
        self.beyond < 0.0
    }

    #[inline]
    fn pdf(&self) -> Pdf<SolidAngle> {
        Pdf::new(0.5 * FRAC_1_PI / self.height)
    }
}

impl Sphere {
    #[inline]
    fn in_direction(&self, normal: Vec3) -> EmitterPoint {
        let parameters = Self::parameters(normal);
        EmitterPoint::of_quadric(self.point(parameters), parameters)
    }
}

impl EmitterShape for Sphere {
    #[inline]
    fn area(&self) -> f32 {
        4.0 * PI * self.radius * self.radius
    }

    #[inline]
    fn sample_area(&self, u: [f32; 2]) -> EmitterPoint {
        self.in_direction(warp::uniform_sphere(u))
    }

    fn normals(&self) -> Cone {
        Cone::ALL
    }

    fn widest(&self) -> f32 {
        PI * self.radius * self.radius
    }

    /// Samples the sphere evenly by solid angle. With θ from the direction to the centre at distance d, the ray meets
    /// the sphere of radius R at t = d·cos θ ∓ R·c, with the cosine c = √(1 − (d·sin θ/R)²) there. Of both solutions
    /// the one that would cancel comes from their product, d² − R².
    #[inline]
    fn sample(&self, from: Vec3, [u, v]: [f32; 2]) -> Option<SeenPoint> {
        let view = View::new(self, from)?;
        let height = u * view.height;
        let (cos, sin2) = (1.0 - height, height * (2.0 - height));
        let (sin, ratio) = (sin2.sqrt(), view.distance / self.radius);
        let cos_at_sphere = (1.0 - sin2 * ratio * ratio).max(0.0).sqrt();
        let (along, half_chord) = (view.distance * cos, self.radius * cos_at_sphere);
        let t = if view.is_inside() && along > 0.0 {
            along + half_chord
        } else {
            view.beyond.abs() / (along.abs() + half_chord)
        };
        let (sin_phi, cos_phi) = (TAU * v).sin_cos();
        let wi = Frame::from_normal(-view.away).to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos));
        Some(SeenPoint {
            point: self.in_direction(view.away * view.distance + wi * t),
            wi,
            cos: if view.is_inside() { -cos_at_sphere } else { cos_at_sphere },
            pdf: view.pdf(),
        })
    }

    #[inline]
    fn pdf(&self, from: Vec3, _: f32, cos: f32) -> Pdf<SolidAngle> {
        let view = View::new(self, from).filter(|view| view.is_inside() == (cos < 0.0));
        view.map_or(Pdf::new(0.0), |view| view.pdf())
    }
}
