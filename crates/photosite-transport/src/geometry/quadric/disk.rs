//! Disks: flat and round.
//!
//! The parameters of a hit are its coordinates in the plane of the disk over the radius.

use std::f32::consts::TAU;

use glam::{DAffine3, Vec2, Vec3};

use super::shape::{QuadricPoint, box_around};
use crate::geometry::bounds::Bounds;
use crate::geometry::word::{QUADRIC_WORDS, Word, word};
use photosite_core::math::float::gamma;
use photosite_core::math::{Real, Vector};

/// A disk in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// Centre, m.
    centre: Vec3,
    /// Vectors from the centre to the rim, at a right angle to each other, m.
    radii: [Vec3; 2],
    /// Radius, m.
    pub(crate) radius: f32,
    /// Unit normal of the front.
    pub(crate) normal: Vec3,
}

impl Disk {
    /// The unit disk, transformed, with its bounds.
    pub(super) fn new(to_world: &DAffine3) -> (Self, Bounds) {
        let [x, y] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis];
        let disk = Self {
            centre: to_world.translation.as_vec3(),
            radii: [x.as_vec3(), y.as_vec3()],
            radius: x.length() as f32,
            normal: x.cross(y).normalize().as_vec3(),
        };
        // Along an axis, x·cos φ + y·sin φ reaches as far as the root of the sum of both squares.
        (disk, box_around(to_world.translation, (x * x + y * y).map(f64::sqrt)))
    }

    /// The disk as plain data, the last word of which is given.
    pub(super) fn words(&self, last: Word) -> [Word; QUADRIC_WORDS] {
        let Self { centre, radii: [x, y], radius, normal } = *self;
        [word(centre, radius.to_bits()), word(x, 0), word(y, 0), word(normal, 0), last]
    }

    /// The t at which a line comes through it, and NaN; twice NaN where it does not: t = (c − o)·n / (d·n), and the
    /// point is no farther than the radius from the centre c.
    #[inline(always)]
    pub(super) fn intersect<R: Real>(&self, origin: Vector<R>, direction: Vector<R>) -> [R; 2] {
        let to_centre = origin.broadcast(self.centre) - origin;
        let normal = origin.broadcast(self.normal);
        // The denominator is what tells the side on which a ray leaves, operation by operation (`offset`): where it is
        // all rounding error, both have the same one.
        let t = to_centre.dot(normal) / direction.dot(normal);
        let from_centre = direction * t - to_centre;
        let nowhere = t.broadcast(f32::NAN);
        // Not where the line is parallel, whose t is no number or infinite.
        let is_inside = from_centre.dot(from_centre).le(t.broadcast(self.radius * self.radius));
        [R::select(is_inside, t, nowhere), nowhere]
    }

    /// The parameters of a point in its plane.
    #[inline]
    pub(super) fn uv(&self, point: Vec3) -> [f32; 2] {
        let from_centre = point - self.centre;
        let squared = self.radius * self.radius;
        self.radii.map(|radius| from_centre.dot(radius) / squared)
    }

    /// The point with these parameters. Beyond the roundings of the point, its error pays for those of (c − o)·n, of
    /// which a ray that leaves the point needs the sign: those of n, of the difference and of the product, each in
    /// proportion to the radius.
    #[inline]
    pub(crate) fn point(&self, [u, v]: [f32; 2]) -> QuadricPoint {
        let [x, y] = self.radii;
        QuadricPoint {
            position: self.centre + (x * u + y * v),
            error: (self.centre.abs() + self.radius) * gamma(3) + self.radius * gamma(12),
            normal: self.normal,
            tangent: if u == 0.0 && v == 0.0 { x } else { y * u - x * v },
        }
    }

    /// Texture coordinates: u runs once around the centre, counter-clockwise seen from the front; v runs from 0 in the
    /// centre to 1 at the rim.
    pub(super) fn texture_coordinates([u, v]: [f32; 2]) -> Vec2 {
        Vec2::new(0.5 + v.atan2(u) / TAU, Vec2::new(u, v).length())
    }
}
