//! Quadrics: surfaces that are exact where triangles have facets. All are given in world space.
//!
//! A hit tells the point of the surface by two numbers (u, v) of the quadric's own, as barycentric weights do for a
//! triangle. The point is computed from them again, so that its rounding error is bounded by the size and the place of
//! the quadric rather than by the distance that the ray came ([pbrt4](photosite_core::references#pbrt4) §6.8).
//!
//! A further shape takes a file with its intersection, parameters, surface point and bounds, and an arm in each `match`
//! here.

mod cylinder;
mod disk;
mod shape;
mod sphere;

use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::word::{QUADRIC_WORDS, Word, word};
use photosite_core::math::{Real, Vector};

pub use cylinder::Cylinder;
pub use disk::Disk;
pub(crate) use shape::QuadricPoint;
pub use sphere::Sphere;

/// The kinds of quadrics, each as a shape of unit size that an instance turns, moves and makes larger or smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuadricKind {
    /// Radius 1 about the origin. Scaled alike in all directions.
    Sphere,
    /// Radius 1 about the origin in the plane z = 0, its front towards +Z. Scaled alike along x and y.
    Disk,
    /// Radius 1 about the z axis from z = 0 to 1, without caps, its front outside. Scaled alike along x and y.
    Cylinder,
}

impl QuadricKind {
    /// Name of the kind in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Disk => "disk",
            Self::Cylinder => "cylinder",
        }
    }

    /// Corners of a box around the unit shape.
    pub fn corners(self) -> Vec<Vec3> {
        let corner = |i: u32, low: f32| {
            let side = |bit: u32, low: f32| if i & bit == 0 { low } else { 1.0 };
            Vec3::new(side(1, -1.0), side(2, -1.0), side(4, low))
        };
        match self {
            Self::Sphere => vec![Vec3::NEG_ONE, Vec3::ONE],
            Self::Disk => (0..4).map(|i| corner(i, 0.0)).collect(),
            Self::Cylinder => (0..8).map(|i| corner(i, 0.0)).collect(),
        }
    }
}

/// A quadric in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quadric {
    /// Sphere around a point.
    Sphere(Sphere),
    /// Flat, with a front and a back.
    Disk(Disk),
    /// Cylinder around an axis, open at both ends.
    Cylinder(Cylinder),
}

/// A quadric of a scene's geometry.
#[derive(Clone, Copy, Debug)]
pub struct PlacedQuadric {
    /// Shape of the quadric and its place in the world.
    pub quadric: Quadric,
    /// Index into [`Geometry::meshes`](super::Geometry::meshes).
    pub mesh: u32,
    /// Lower and upper corner of its box, m.
    pub bounds: (Vec3, Vec3),
}

impl PlacedQuadric {
    /// A unit shape, transformed.
    pub fn new(kind: QuadricKind, to_world: &DAffine3, mesh: u32) -> Self {
        let (quadric, bounds) = match kind {
            QuadricKind::Sphere => {
                let (centre, radius) = (to_world.translation, to_world.matrix3.x_axis.length());
                let sphere = Sphere { centre: centre.as_vec3(), radius: radius as f32 };
                (Quadric::Sphere(sphere), shape::box_around(centre, DVec3::splat(radius)))
            }
            QuadricKind::Disk => {
                let (disk, bounds) = Disk::new(to_world);
                (Quadric::Disk(disk), bounds)
            }
            QuadricKind::Cylinder => {
                let (cylinder, bounds) = Cylinder::new(to_world);
                (Quadric::Cylinder(cylinder), bounds)
            }
        };
        Self { quadric, mesh, bounds }
    }
}

impl Quadric {
    /// The two t at which a line meets it, the smaller one first; NaN where it does not.
    #[inline(always)]
    pub(crate) fn intersect<R: Real>(&self, origin: Vector<R>, direction: Vector<R>) -> [R; 2] {
        match self {
            Self::Sphere(sphere) => sphere.intersect(origin, direction),
            Self::Disk(disk) => disk.intersect(origin, direction),
            Self::Cylinder(cylinder) => cylinder.intersect(origin, direction),
        }
    }

    /// The quadric of a mesh as plain data: a place with the radius, three vectors, and the kind with the mesh.
    pub(crate) fn words(&self, mesh: u32) -> [Word; QUADRIC_WORDS] {
        let zero = word(Vec3::ZERO, 0);
        match self {
            Self::Sphere(Sphere { centre, radius }) => {
                [word(*centre, radius.to_bits()), zero, zero, zero, [0, mesh, 0, 0]]
            }
            Self::Disk(disk) => disk.words([1, mesh, 0, 0]),
            Self::Cylinder(Cylinder { middle, axes: [x, y, z], radius, half_length }) => {
                let place = word(*middle, radius.to_bits());
                [place, word(*x, half_length.to_bits()), word(*y, 0), word(*z, 0), [2, mesh, 0, 0]]
            }
        }
    }

    /// The parameters of a point of it, or near it.
    #[inline]
    pub(crate) fn uv(&self, point: Vec3) -> [f32; 2] {
        match self {
            Self::Sphere(sphere) => sphere.uv(point),
            Self::Disk(disk) => disk.uv(point),
            Self::Cylinder(cylinder) => cylinder.uv(point),
        }
    }

    /// The point with these parameters.
    #[inline]
    pub(crate) fn point(&self, uv: [f32; 2]) -> QuadricPoint {
        match self {
            Self::Sphere(sphere) => sphere.point(uv),
            Self::Disk(disk) => disk.point(uv),
            Self::Cylinder(cylinder) => cylinder.point(uv),
        }
    }

    /// Coordinates for textures of the point with these parameters.
    pub(super) fn texture_coordinates(&self, uv: [f32; 2]) -> Vec2 {
        match self {
            Self::Sphere(_) => Sphere::texture_coordinates(uv),
            Self::Disk(_) => Disk::texture_coordinates(uv),
            Self::Cylinder(_) => Cylinder::texture_coordinates(uv),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use glam::DQuat;

    use super::*;
    use crate::geometry::accel_tests::Numbers;
    use crate::geometry::{Ray, offset_origin};
    use photosite_core::math::warp;

    /// Disks and cylinders of several sizes and shapes, in several places, turned anyhow.
    fn turned(kind: QuadricKind) -> impl Iterator<Item = (PlacedQuadric, f32)> {
        let cases = [(0.0, 1.0, 1.0), (3.0, 0.35, 2.0), (100.0, 1e-2, 0.5), (-1.0, 1e4, 0.1), (0.5, 0.02, 20.0)];
        cases.into_iter().enumerate().map(move |(i, (offset, radius, length))| {
            let turn = DQuat::from_rotation_x(i as f64) * DQuat::from_rotation_y(0.7 * i as f64);
            let scale = DVec3::new(radius, radius, radius * length);
            let centre = DVec3::new(offset, -offset, 0.3 * offset);
            let to_world = DAffine3::from_scale_rotation_translation(scale, turn, centre);
            (PlacedQuadric::new(kind, &to_world, 0), (radius * f64::max(1.0, length)) as f32)
        })
    }

    fn nearest(quadric: &Quadric, origin: Vec3, direction: Vec3) -> Option<f32> {
        let sides = quadric.intersect(Vector::from(origin), Vector::from(direction));
        sides.into_iter().find(|&t| 0.0 < t && t < f32::INFINITY)
    }

    /// A grid of quads over the parameters as triangles, which meet the quadric in their corners.
    fn tessellated(kind: QuadricKind, to_world: &DAffine3, sectors: u32) -> Vec<[Vec3; 3]> {
        let point = |i: u32, end: u32| {
            let (sin, cos) = f64::from(TAU * (i % sectors) as f32 / sectors as f32).sin_cos();
            let unit = match kind {
                QuadricKind::Disk => DVec3::new(cos * f64::from(end), sin * f64::from(end), 0.0),
                QuadricKind::Cylinder | QuadricKind::Sphere => DVec3::new(cos, sin, f64::from(end)),
            };
            to_world.transform_point3(unit).as_vec3()
        };
        (0..sectors)
            .flat_map(|i| {
                let [a, b, c, d] = [point(i, 0), point(i + 1, 0), point(i + 1, 1), point(i, 1)];
                match kind {
                    QuadricKind::Disk => vec![[a, d, c]],
                    QuadricKind::Cylinder | QuadricKind::Sphere => vec![[a, b, c], [a, c, d]],
                }
            })
            .collect()
    }

    #[test]
    fn rays_meet_disks_and_cylinders_where_they_meet_meshes_of_the_same_shape() {
        let mut numbers = Numbers(17);
        for kind in [QuadricKind::Disk, QuadricKind::Cylinder] {
            let turn = DQuat::from_rotation_x(0.4) * DQuat::from_rotation_y(1.1);
            let (scale, centre) = (DVec3::new(0.4, 0.4, 0.9), DVec3::new(0.2, -0.1, 0.3));
            let to_world = DAffine3::from_scale_rotation_translation(scale, turn, centre);
            let placed = PlacedQuadric::new(kind, &to_world, 0);
            // The chord of a sector of 2π/720 lies (1 − cos(π/720))·0.4 m = 4 µm inside.
            let triangles = tessellated(kind, &to_world, 720);
            let mesh = crate::geometry::accel_tests::geometry(&triangles);
            let accel = crate::geometry::accel_tests::in_world(&mesh);
            let (mut hits, mut differing) = (0, 0);
            for _ in 0..4000 {
                let origin = numbers.point() * 3.0 - 1.5;
                let target = centre.as_vec3() + (numbers.point() - 0.5) * 1.4;
                let ray = Ray::new(origin, (target - origin) * (0.2 + numbers.next()));
                let of_mesh = accel.closest(&ray, &crate::geometry::AcceptAll);
                let found = nearest(&placed.quadric, ray.origin, ray.direction);
                let (Some(of_mesh), Some(t)) = (of_mesh, found) else {
                    differing += u32::from(of_mesh.is_some() != found.is_some());
                    continue;
                };
                // Past the rim of one, a ray may meet the far side of the other.
                let apart = (ray.at(t) - ray.at(of_mesh.t)).length();
                if apart > 0.05 {
                    differing += 1;
                    continue;
                }
                hits += 1;
                let point = placed.quadric.point(placed.quadric.uv(ray.at(t)));
                let cos = (point.normal.dot(ray.direction) / ray.direction.length()).abs();
                // Some sixteen roundings lie between the corners or the quadric and t, each relative to the way to
                // them.
                let rounding = 16.0 * 0.5 * f32::EPSILON * ((ray.origin - centre.as_vec3()).length() + 1.0);
                assert!(apart * cos < 4e-6 + rounding || cos < 0.05, "{kind:?}: {apart} at {cos}");
                assert!((point.position - ray.at(t)).length() * cos < rounding, "{kind:?} at {cos}");
                let (low, high) = placed.bounds;
                assert!(point.position.cmpge(low).all() && point.position.cmple(high).all(), "{kind:?}");
                // The normal is that of the mesh but for half a sector's angle of 0.25°, and its front is outside.
                let [a, b, c] = triangles[of_mesh.primitive.triangle().expect("a mesh of triangles") as usize];
                let normal = (b - a).cross(c - a).normalize();
                assert!(normal.dot(point.normal) > 0.9999, "{kind:?}: {normal} {}", point.normal);
            }
            assert!(hits > 500 && differing <= 12, "{kind:?}: {hits} hits, {differing} differ");
        }
    }

    #[test]
    fn parameters_lead_back_to_the_point() {
        let mut numbers = Numbers(41);
        for kind in [QuadricKind::Disk, QuadricKind::Cylinder] {
            for (placed, size) in turned(kind) {
                let quadric = placed.quadric;
                for _ in 0..1000 {
                    let uv = match kind {
                        QuadricKind::Disk => {
                            let [x, y] = warp::concentric_disk([numbers.next(), numbers.next()]);
                            [x, y]
                        }
                        QuadricKind::Sphere | QuadricKind::Cylinder => {
                            [numbers.next() * 4.0 - 2.0, numbers.next() * 2.0 - 1.0]
                        }
                    };
                    let point = quadric.point(uv);
                    let back = quadric.point(quadric.uv(point.position));
                    // What is rounded is the position, relative to the size of the quadric and to its distance from the
                    // origin.
                    let tolerance = 1e-6 * (size + point.position.length());
                    assert!((back.position - point.position).length() < tolerance, "{kind:?} {uv:?}");
                    assert!((point.normal.length() - 1.0).abs() < 1e-6);
                    let step = |direction: Vec3| {
                        let moved = point.position + direction.normalize() * (0.01 * size.min(point.tangent.length()));
                        quadric.texture_coordinates(quadric.uv(moved))
                    };
                    let (here, along) = (quadric.texture_coordinates(uv), step(point.tangent));
                    let is_seam = !(0.1..0.9).contains(&here.x) || here.y < 0.1 && kind == QuadricKind::Disk;
                    let is_far = point.position.length() > 30.0 * size;
                    assert!(is_seam || is_far || along.x > here.x, "{kind:?} {here} {along}");
                }
            }
        }
    }

    #[test]
    fn rays_that_leave_disks_and_cylinders_do_not_meet_them_again_and_those_inside_do() {
        let mut numbers = Numbers(9);
        for kind in [QuadricKind::Disk, QuadricKind::Cylinder] {
            for (placed, _) in turned(kind) {
                let quadric = placed.quadric;
                for _ in 0..20_000 {
                    let uv = match kind {
                        QuadricKind::Disk => warp::concentric_disk([numbers.next(), numbers.next()]),
                        QuadricKind::Sphere | QuadricKind::Cylinder => {
                            [numbers.next() * 4.0 - 2.0, numbers.next() * 2.0 - 1.0]
                        }
                    };
                    let QuadricPoint { position, error, normal, .. } = quadric.point(uv);
                    let other = warp::uniform_sphere([numbers.next(), numbers.next()]);
                    let cos = 10f32.powf(-3.0 * numbers.next());
                    let direction = (normal * cos + other - normal * other.dot(normal)).normalize();
                    let outside = offset_origin(position, error, normal, direction);
                    assert_eq!(nearest(&quadric, outside, direction * 5.0), None, "{quadric:?} {uv:?} {direction}");
                    let inward = direction - normal * (2.0 * direction.dot(normal));
                    let inside = offset_origin(position, error, normal, inward);
                    match (kind, nearest(&quadric, inside, inward)) {
                        // Behind a disk there is nothing more.
                        (QuadricKind::Disk, found) => assert_eq!(found, None),
                        // Through a cylinder the chord is long, or ends beyond one of the ends.
                        (QuadricKind::Sphere | QuadricKind::Cylinder, Some(t)) => {
                            let Quadric::Cylinder(cylinder) = quadric else { unreachable!("a cylinder") };
                            let chord = 2.0 * cylinder.radius * direction.dot(normal);
                            assert!(t > 0.5 * chord, "{quadric:?}: {t} of {chord}");
                        }
                        (QuadricKind::Sphere | QuadricKind::Cylinder, None) => {}
                    }
                }
            }
        }
    }

    #[test]
    fn lines_meet_as_much_of_each_as_cauchy_says() {
        // Of uniformly random lines through a ball of radius R, the mean number of hits with a surface of area A inside
        // is A/(2πR²): ⟨|cos|⟩·A over the ball's cross-section πR², each line counted once for each crossing.
        let mut numbers = Numbers(77);
        const LINES: u32 = 40_000;
        for (kind, area) in [(QuadricKind::Disk, 0.16 * TAU / 2.0), (QuadricKind::Cylinder, TAU * 0.4 * 0.9)] {
            let turn = DQuat::from_rotation_x(2.4) * DQuat::from_rotation_y(0.3);
            let to_world = DAffine3::from_scale_rotation_translation(DVec3::new(0.4, 0.4, 0.9), turn, DVec3::ZERO);
            let quadric = PlacedQuadric::new(kind, &to_world, 0).quadric;
            let mut hits = 0;
            for _ in 0..LINES {
                let direction = warp::uniform_sphere([numbers.next(), numbers.next()]);
                let [x, y] = warp::concentric_disk([numbers.next(), numbers.next()]);
                let [a, b] = photosite_core::math::frame::tangents(Vector::from(direction)).map(Vec3::from);
                let origin = a * x + b * y - direction * 3.0;
                let sides = quadric.intersect(Vector::from(origin), Vector::from(direction));
                hits += sides.iter().filter(|t| t.is_finite()).count();
            }
            let (expected, found) = (area / TAU, hits as f32 / LINES as f32);
            // Two crossings at most: the variance of a line is below 4, and mostly far below; five deviations.
            let tolerance = 5.0 * (2.0 * expected / LINES as f32).sqrt();
            assert!((found - expected).abs() < tolerance, "{kind:?}: {found} for {expected} ± {tolerance}");
        }
    }
}
