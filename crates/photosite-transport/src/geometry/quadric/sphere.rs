//! Spheres: where a ray meets one, and what its surface is like there.
//!
//! The parameters of a hit are its direction from the centre: the octahedron |x|+|y|+|z| = 1,
//! unfolded into a square (Z. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
//! JCGT 3(2), 2014, §3).

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec2, Vec3};

use super::shape::QuadricPoint;
use photosite_core::math::float::gamma;
use photosite_core::math::{Real, Vector};

/// A sphere in world space; its front is its outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, m.
    pub centre: Vec3,
    /// Radius, m, above 0.
    pub radius: f32,
}

impl Sphere {
    /// The two t at which a line meets it, the smaller one first; not numbers where it does not.
    ///
    /// With f from the centre to the origin, t solves t²·d² + 2t·f·d + f² − r² = 0. The discriminant comes from the
    /// distance of the centre from the line, and of the two solutions the one that would cancel from their product, f²
    /// − r² over d²: that keeps the digits of spheres that are small for their distance, and the sign of t for rays
    /// that leave the surface (E. Haines et al., "Precision Improvements for Ray/Sphere Intersection", in Ray Tracing
    /// Gems, 2019).
    #[inline(always)]
    pub(super) fn intersect<R: Real>(&self, origin: Vector<R>, direction: Vector<R>) -> [R; 2] {
        let from_centre = origin - origin.broadcast(self.centre);
        let a = direction.dot(direction);
        let (zero, radius, nowhere) = (a.broadcast(0.0), a.broadcast(self.radius), a.broadcast(f32::NAN));
        let b = -from_centre.dot(direction);
        let nearest = from_centre + direction * (b / a);
        let discriminant = radius * radius - nearest.dot(nearest);
        let q = b + (a * discriminant.max(zero)).sqrt().copysign(b);
        let (t0, t1) = ((from_centre.dot(from_centre) - radius * radius) / q, q / a);
        let is_met = zero.le(discriminant);
        [R::select(is_met, t0.min(t1), nowhere), R::select(is_met, t0.max(t1), nowhere)]
    }

    /// The parameters of a point near its surface.
    #[inline]
    pub(super) fn uv(&self, point: Vec3) -> [f32; 2] {
        Self::parameters(point - self.centre)
    }

    /// The parameters of the point in a direction from the centre.
    #[inline]
    pub(crate) fn parameters(from_centre: Vec3) -> [f32; 2] {
        let [x, y, z] = (from_centre / from_centre.abs().element_sum()).to_array();
        let fold = |a: f32, b: f32| (1.0 - b.abs()).copysign(a);
        if z < 0.0 { [fold(x, y), fold(y, x)] } else { [x, y] }
    }

    /// The unit normal outwards of the point with these parameters.
    #[inline]
    fn normal([u, v]: [f32; 2]) -> Vec3 {
        let z = 1.0 - u.abs() - v.abs();
        let beyond = (-z).max(0.0);
        Vec3::new(u - beyond.copysign(u), v - beyond.copysign(v), z).normalize()
    }

    /// The point with these parameters. Beyond the roundings of the point, its error pays for those of f² − r² in
    /// [`intersect`](Self::intersect), of which a ray that leaves the point needs the sign: 7u·r², over 2r.
    #[inline]
    pub(crate) fn point(&self, uv: [f32; 2]) -> QuadricPoint {
        let normal = Self::normal(uv);
        QuadricPoint {
            position: self.centre + normal * self.radius,
            error: (self.centre.abs() + self.radius) * gamma(3) + self.radius * gamma(12),
            normal,
            tangent: Vec3::new(normal.z, 0.0, -normal.x),
        }
    }

    /// Texture coordinates: u runs once around +Y, to the right as seen from outside with +Y up and ½ in the direction
    /// +Z; v runs down from 0 at +Y to 1.
    pub(super) fn texture_coordinates(uv: [f32; 2]) -> Vec2 {
        let Vec3 { x, y, z } = Self::normal(uv);
        Vec2::new(0.5 + x.atan2(z) / TAU, y.clamp(-1.0, 1.0).acos() * FRAC_1_PI)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::accel_tests::Numbers;
    use crate::geometry::offset_origin;
    use photosite_core::math::warp;

    fn meet(sphere: &Sphere, origin: Vec3, direction: Vec3, t_max: f32) -> Option<f32> {
        let sides = sphere.intersect(Vector::from(origin), Vector::from(direction));
        sides.into_iter().find(|&t| 0.0 < t && t < t_max)
    }

    #[test]
    fn a_ray_meets_a_sphere_where_the_quadratic_formula_says() {
        let mut numbers = Numbers(31);
        let mut hits = 0;
        for (radius, distance) in [(1.0f32, 3.0f32), (1e-3, 3.0), (1e3, 2e3), (1.0, 0.5)] {
            let sphere = Sphere { centre: Vec3::new(0.3, -0.2, 0.1), radius };
            for _ in 0..2000 {
                let origin = sphere.centre + warp::uniform_sphere([numbers.next(), numbers.next()]) * distance;
                let target = sphere.centre + (numbers.point() * 2.0 - 1.0) * radius;
                let direction = (target - origin) * (0.1 + numbers.next());
                let (f, d) = ((origin.as_dvec3() - sphere.centre.as_dvec3()), direction.as_dvec3());
                let r = f64::from(radius);
                let (a, b, c) = (d.dot(d), f.dot(d), f.dot(f) - r * r);
                let discriminant = b * b - a * c;
                // Where the ray grazes, single precision may decide either way.
                if discriminant.abs() < 1e-4 * a * r * r {
                    continue;
                }
                let root = discriminant.max(0.0).sqrt();
                let expected = [(-b - root) / a, (-b + root) / a].into_iter().find(|&t| discriminant > 0.0 && t > 0.0);
                let found = meet(&sphere, origin, direction, f32::INFINITY);
                assert_eq!(found.is_some(), expected.is_some(), "{sphere:?} {origin} {direction}");
                let (Some(t), Some(expected)) = (found, expected) else { continue };
                hits += 1;
                let point = f + d * f64::from(t);
                assert!(
                    (point.length() / r - 1.0).abs() < 3e-5 * f64::from(1f32.max(distance / radius)) / 100.0 + 3e-5
                );
                assert!((f64::from(t) / expected - 1.0).abs() < 1e-4, "{t} {expected}");
                assert_eq!(meet(&sphere, origin, direction, t), None, "not beyond the end");
            }
        }
        assert!(hits > 3000, "{hits}");
    }

    #[test]
    fn parameters_lead_back_to_the_point() {
        let mut random = Numbers(3);
        let sphere = Sphere { centre: Vec3::new(-4.0, 2.0, 0.5), radius: 0.7 };
        let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        let others = (0..1000).map(|_| warp::uniform_sphere([random.next(), random.next()]));
        for normal in axes.into_iter().chain(others) {
            let uv = sphere.uv(sphere.centre + normal * sphere.radius);
            let QuadricPoint { position: point, error, tangent, .. } = sphere.point(uv);
            let back = Sphere::normal(sphere.uv(point));
            // The centre is seven times as far as the surface, and its rounding is divided by the radius.
            assert!((back - normal).length() < 4e-6, "{normal} {back}");
            assert!(
                (point.as_dvec3() - sphere.centre.as_dvec3() - Sphere::normal(uv).as_dvec3() * 0.7)
                    .abs()
                    .cmple(error.as_dvec3() + DVec3::splat(1e-7))
                    .all()
            );
            let [uv, right, down] = [Vec3::ZERO, tangent, Vec3::NEG_Y].map(|step| {
                let stepped = sphere.centre + (normal + step * 1e-3).normalize() * sphere.radius;
                Sphere::texture_coordinates(sphere.uv(stepped))
            });
            if normal.y.abs() < 0.9 && normal.z > -0.9 {
                assert!(right.x > uv.x && (right.y - uv.y).abs() < 1e-3 && down.y > uv.y, "{normal}");
            }
        }
    }

    #[test]
    fn rays_that_leave_a_sphere_do_not_meet_it_again_and_those_that_go_in_do() {
        let mut numbers = Numbers(8);
        for (centre, radius) in [(0.0, 1.0), (3.0, 0.35), (100.0, 1e-2), (-1.0, 1e4)] {
            let sphere = Sphere { centre: Vec3::new(centre, -centre, 0.3 * centre), radius };
            for _ in 0..20_000 {
                let normal = warp::uniform_sphere([numbers.next(), numbers.next()]);
                let QuadricPoint { position: point, error, normal, .. } =
                    sphere.point(sphere.uv(sphere.centre + normal * sphere.radius));
                let other = warp::uniform_sphere([numbers.next(), numbers.next()]);
                let direction =
                    (normal * 10f32.powf(-4.0 * numbers.next()) + other - normal * other.dot(normal)).normalize();
                let outside = offset_origin(point, error, normal, direction);
                assert_eq!(
                    meet(&sphere, outside, direction * 5.0, f32::INFINITY),
                    None,
                    "{sphere:?} {normal} {direction}"
                );
                let inside = offset_origin(point, error, normal, -normal);
                let inward = direction - normal * (2.0 * direction.dot(normal));
                let t = meet(&sphere, inside, inward, f32::INFINITY).expect("the other side");
                let chord = 2.0 * radius * direction.dot(normal);
                assert!(t > 0.5 * chord, "{sphere:?}: {t} of {chord}");
            }
        }
    }
}
