//! Cylinders, sampled evenly over the part of their area that may be seen: from outside the arc of their front that faces
//! the point, from inside all of their back. What is seen of the back from outside, through an end, is left to BSDF
//! sampling, so that a cylinder never hides its own sample.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::{EmitterPoint, EmitterShape, SeenPoint};
use crate::geometry::Cylinder;
use photosite_core::math::float::gamma;
use photosite_core::math::{Area, Cone, Pdf, SolidAngle};

/// The part of a cylinder that may be seen from a point.
struct VisibleArc {
    /// Middle of the arc, a unit vector across the axis.
    middle: Vec2,
    /// Half of its angle, rad.
    half_angle: f32,
    is_inside: bool,
}

impl VisibleArc {
    /// Arc that is seen from a point; `None` from the surface itself, within its rounding.
    #[inline]
    fn new(cylinder: &Cylinder, from: Vec3) -> Option<Self> {
        let from_middle = from - cylinder.middle;
        let across = Vec2::new(from_middle.dot(cylinder.axes[0]), from_middle.dot(cylinder.axes[1]));
        let distance = across.length();
        let outside = distance - cylinder.radius;
        let rounding = cylinder.middle.abs().max_element() + from_middle.abs().max_element() + cylinder.radius;
        if outside.abs() <= rounding * gamma(16) {
            return None;
        }
        let is_inside = outside < 0.0;
        let half_angle = match is_inside {
            true => PI,
            false => (outside * (distance + cylinder.radius)).sqrt().atan2(cylinder.radius),
        };
        Some(Self { middle: if is_inside { Vec2::X } else { across / distance }, half_angle, is_inside })
    }

    #[inline]
    fn pdf(&self, cylinder: &Cylinder) -> Pdf<Area> {
        Pdf::new(0.25 / (self.half_angle * cylinder.radius * cylinder.half_length))
    }
}

impl Cylinder {
    /// The point in a direction across the axis, at a distance from the middle along it over half of the length.
    #[inline]
    fn towards(&self, across: Vec2, along: f32) -> EmitterPoint {
        let parameters = [Self::parameter(across), along];
        EmitterPoint::of_quadric(self.point(parameters), parameters)
    }
}

impl EmitterShape for Cylinder {
    #[inline]
    fn area(&self) -> f32 {
        2.0 * TAU * self.radius * self.half_length
    }

    #[inline]
    fn sample_area(&self, [u, v]: [f32; 2]) -> EmitterPoint {
        self.towards(Vec2::from_angle(TAU * u), 2.0 * v - 1.0)
    }

    fn normals(&self) -> Cone {
        Cone::ALL
    }

    fn widest(&self) -> f32 {
        4.0 * self.radius * self.half_length
    }

    #[inline]
    fn sample(&self, from: Vec3, [u, v]: [f32; 2]) -> Option<SeenPoint> {
        let arc = VisibleArc::new(self, from)?;
        let across = arc.middle.rotate(Vec2::from_angle(arc.half_angle * (2.0 * u - 1.0)));
        let seen = self.towards(across, 2.0 * v - 1.0).seen_from(from, arc.pdf(self));
        (arc.is_inside == (seen.cos < 0.0)).then_some(seen)
    }

    #[inline]
    fn pdf(&self, from: Vec3, distance: f32, cos: f32) -> Pdf<SolidAngle> {
        let arc = VisibleArc::new(self, from).filter(|arc| arc.is_inside == (cos < 0.0));
        arc.map_or(Pdf::new(0.0), |arc| arc.pdf(self).to_solid_angle(distance * distance, cos.abs()))
    }
}
