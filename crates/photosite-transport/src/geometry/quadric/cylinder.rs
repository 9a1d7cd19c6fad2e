//! Cylinders: round, straight, and open at both ends.
//!
//! The parameters of a hit are its direction from the axis and its distance from the middle over half of the length.
//! The direction is told by one number from −2 to 2, the way around the square |x| + |y| = 1, which needs no
//! trigonometric functions.

use std::f32::consts::TAU;

use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::shape::{QuadricPoint, box_around};
use crate::geometry::bounds::Bounds;
use photosite_core::math::float::gamma;
use photosite_core::math::{Real, Vector};

/// A cylinder in world space; its front is its outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// The middle of its axis, m.
    pub(crate) middle: Vec3,
    /// Unit vectors at right angles, the third along the axis.
    pub(crate) axes: [Vec3; 3],
    /// Radius, m.
    pub(crate) radius: f32,
    /// Half of the length, m.
    pub(crate) half_length: f32,
}

impl Cylinder {
    /// The unit cylinder, transformed, with its bounds.
    pub(super) fn new(to_world: &DAffine3) -> (Self, Bounds) {
        let [x, y, z] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis, to_world.matrix3.z_axis];
        let (radius, half_length, axis) = (x.length(), z.length() / 2.0, z.normalize());
        let middle = to_world.transform_point3(DVec3::Z / 2.0);
        let cylinder = Self {
            middle: middle.as_vec3(),
            axes: [x / radius, y / radius, axis].map(|axis| axis.as_vec3()),
            radius: radius as f32,
            half_length: half_length as f32,
        };
        let across = (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt);
        (cylinder, box_around(middle, axis.abs() * half_length + across * radius))
    }

    /// The two t at which a line meets it, the smaller one first; NaN where it does not.
    ///
    /// With f and d without their parts along the axis, t is that of a [sphere](super::Sphere::intersect): t²·d² +
    /// 2t·f·d + f² − r² = 0. What is farther from the middle than half of the length does not count.
    #[inline(always)]
    pub(super) fn intersect<R: Real>(&self, origin: Vector<R>, direction: Vector<R>) -> [R; 2] {
        let from_middle = origin - origin.broadcast(self.middle);
        let axis = origin.broadcast(self.axes[2]);
        let (f_along, d_along) = (from_middle.dot(axis), direction.dot(axis));
        let (f, d) = (from_middle - axis * f_along, direction - axis * d_along);
        let a = d.dot(d);
        let b = -f.dot(d);
        let (zero, radius, nowhere) = (a.broadcast(0.0), a.broadcast(self.radius), a.broadcast(f32::NAN));
        // The discriminant from the distance of the line from the axis, which keeps the digits of thin cylinders.
        let nearest = f + d * (b / a);
        let discriminant = radius * radius - nearest.dot(nearest);
        let q = b + (a * discriminant.max(zero)).sqrt().copysign(b);
        // Of both solutions the one that would cancel comes from their product.
        let (t0, t1) = ((f.dot(f) - radius * radius) / q, q / a);
        let is_met = zero.le(discriminant);
        let half_length = a.broadcast(self.half_length);
        let near = t0.min(t1);
        let far = t0.max(t1);
        let is_near_within = is_met & (f_along + d_along * near).abs().le(half_length);
        let is_far_within = is_met & (f_along + d_along * far).abs().le(half_length);
        [R::select(is_near_within, near, nowhere), R::select(is_far_within, far, nowhere)]
    }

    /// The parameters of a point near its surface.
    #[inline]
    pub(super) fn uv(&self, point: Vec3) -> [f32; 2] {
        let from_middle = point - self.middle;
        let [x, y, z] = self.axes.map(|axis| from_middle.dot(axis));
        [Self::parameter(Vec2::new(x, y)), z / self.half_length]
    }

    /// The first parameter in a direction across the axis, of any length.
    #[inline]
    pub(crate) fn parameter(Vec2 { x, y }: Vec2) -> f32 {
        let x = x / (x.abs() + y.abs());
        (1.0 - x).copysign(y)
    }

    /// The point with these parameters. Beyond the roundings of the point, its error pays for those of f² − r² in
    /// [`intersect`](Self::intersect), of which a ray that leaves the point needs the sign: f comes from differences as
    /// large as half of the length and the radius together.
    #[inline]
    pub(crate) fn point(&self, [u, v]: [f32; 2]) -> QuadricPoint {
        let [x, y, axis] = self.axes;
        let [cos, sin] = direction(u);
        let normal = (x * cos + y * sin).normalize();
        let size = self.radius + self.half_length;
        QuadricPoint {
            position: self.middle + (axis * (v * self.half_length) + normal * self.radius),
            error: (self.middle.abs() + size) * gamma(3) + size * gamma(16),
            normal,
            tangent: y * cos - x * sin,
        }
    }

    /// Texture coordinates: u runs once around the axis, to the right as seen from outside with the axis up; v runs
    /// down from 0 at the end that the axis points to, to 1.
    pub(super) fn texture_coordinates([u, v]: [f32; 2]) -> Vec2 {
        let [cos, sin] = direction(u);
        Vec2::new(0.5 + sin.atan2(cos) / TAU, 0.5 - 0.5 * v)
    }
}

/// Cosine and sine of a direction around the axis.
#[inline]
fn direction(u: f32) -> [f32; 2] {
    let cos = 1.0 - u.abs();
    let sin = (1.0 - cos.abs()).copysign(u);
    Vec2::new(cos, sin).normalize().to_array()
}
