//! Rays, hits, and how a ray leaves a surface without meeting it again.

use glam::Vec3;

use super::{Facet, Primitive};
use photosite_core::math::{Real, Vector};

/// A ray from `origin` along `direction`; points on it are origin + t·direction for 0 < t < `t_max`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin of the ray, m.
    pub origin: Vec3,
    /// Direction of any length above 0; t is counted in that length.
    pub direction: Vec3,
    /// Parameter t at which the ray ends; infinite for a ray without end.
    pub t_max: f32,
    /// Time at which the ray meets the scene: 0 for the start and 1 for the end of the time for which the scene was
    /// built.
    pub time: f32,
    /// Triangle that the ray leaves, and does not meet.
    pub from: Facet,
    /// Primitive of a light that the ray ends at (`Primitive::target`), which does not hide itself and has a single
    /// place; [`Facet::NO_TRIANGLE`] for none. Occlusion queries alone heed it.
    pub to: u32,
}

impl Ray {
    /// Placeholder of no ray.
    pub(crate) const NONE: Self = Self {
        origin: Vec3::ZERO,
        direction: Vec3::ZERO,
        t_max: 0.0,
        time: 0.0,
        from: Facet::NONE,
        to: Facet::NO_TRIANGLE,
    };

    /// Makes a ray without end at time 0, which leaves no triangle.
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_max: f32::INFINITY, time: 0.0, from: Facet::NONE, to: Facet::NO_TRIANGLE }
    }

    /// Returns the ray at another time.
    #[inline]
    #[must_use]
    pub fn at_time(self, time: f32) -> Self {
        Self { time, ..self }
    }

    /// Returns the ray as one that leaves a triangle.
    #[inline]
    #[must_use]
    pub fn leaving(self, from: Facet) -> Self {
        Self { from, ..self }
    }

    /// Point of the ray at the parameter t.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Intersection of a ray with a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter t of the hit.
    pub t: f32,
    /// Position on the primitive: barycentric weights of a triangle's second and third corner, the parameters of a
    /// [`Quadric`](super::Quadric).
    pub uv: [f32; 2],
    /// Primitive that the ray meets.
    pub primitive: Primitive,
    /// Index of the instance in [`Accel`](super::Accel).
    pub instance: u32,
}

impl Hit {
    /// Triangle that a ray from the hit leaves.
    #[inline]
    pub fn facet(&self) -> Facet {
        Facet::of(self.instance, self.primitive)
    }
}

/// A ray origin off the surface at `p`, on the side that `direction` points to.
///
/// `error` bounds the rounding error of p per axis (m), `normal` is the unit geometric normal n. The point moves along
/// the normal just far enough to clear the box p ± error, by d = Σ |nᵢ|·errorᵢ
/// ([pbrt4](photosite_core::references#pbrt4) §6.8.6), and by what the sum p + d·n may lose along n when it is rounded:
/// at most Σ |nᵢ|·u·|pᵢ + d·nᵢ|, with u = 2⁻²⁴.
#[inline]
pub fn offset_origin(p: Vec3, error: Vec3, normal: Vec3, direction: Vec3) -> Vec3 {
    offset(p.into(), error.into(), normal.into(), direction.into()).into()
}

/// Moves the origin as [`offset_origin`] does, for any type of real numbers.
#[inline(always)]
pub(crate) fn offset<R: Real>(p: Vector<R>, error: Vector<R>, normal: Vector<R>, direction: Vector<R>) -> Vector<R> {
    let u = 0.5 * f32::EPSILON;
    // Twice u for p, and four times for d, pay for the roundings of these products too.
    let distance = normal.abs().dot(error + p.abs() * p.x.broadcast(2.0 * u)) * p.x.broadcast(1.0 + 4.0 * u);
    p + normal * distance.copysign(direction.dot(normal))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_origin_leaves_on_the_side_it_points_to_at_every_scale() {
        for scale in [1e-12f32, 1.0, 1e12] {
            let p = Vec3::new(1.0, -2.0, 3.0) * scale;
            let error = p.abs() * 1e-6;
            for direction in [Vec3::Y, Vec3::NEG_Y] {
                let origin = offset_origin(p, error, Vec3::Y, direction);
                let height = (origin.y - p.y) * direction.y;
                assert!(height > error.y && height < 2.0 * error.y, "{scale}: {height}");
            }
        }
    }
}
