//! Samples of quadrics against rays that meet them.

use glam::{DAffine3, DQuat, DVec3, Vec3};

use super::{Emitter, EmitterShape};
use crate::geometry::accel_tests::Numbers;
use crate::geometry::{PlacedQuadric, Quadric, QuadricKind};
use photosite_core::math::{Vector, warp};

/// Shapes as they are seen from the origin, with the side that is seen, ±1.
fn views() -> Vec<(Quadric, f32)> {
    let placed = |kind, size, place| {
        let turn = DQuat::from_rotation_x(0.4) * DQuat::from_rotation_y(1.1);
        PlacedQuadric::new(kind, &DAffine3::from_scale_rotation_translation(size, turn, place), 0).quadric
    };
    let (sphere, disk, cylinder) = (QuadricKind::Sphere, QuadricKind::Disk, QuadricKind::Cylinder);
    vec![
        (placed(sphere, DVec3::ONE, DVec3::new(0.8, 0.9, 0.3)), 1.0),
        (placed(sphere, DVec3::ONE, DVec3::new(0.6, 0.801, 0.0)), 1.0),
        (placed(sphere, DVec3::splat(0.05), DVec3::new(0.3, -0.4, 0.3)), 1.0),
        (placed(sphere, DVec3::ONE, DVec3::new(0.5, -0.7, 0.3)), -1.0),
        (placed(sphere, DVec3::ONE, DVec3::new(0.599, 0.8, 0.0)), -1.0),
        (placed(sphere, DVec3::ONE, DVec3::ZERO), -1.0),
        (placed(disk, DVec3::ONE, DVec3::new(-0.5, 0.7, 0.3)), 1.0),
        (placed(disk, DVec3::ONE, DVec3::new(0.5, -0.7, -0.3)), -1.0),
        // From aside, from beyond an end, and from inside.
        (placed(cylinder, DVec3::new(0.5, 0.5, 2.0), DVec3::new(-1.4, 0.2, -1.8)), 1.0),
        (placed(cylinder, DVec3::new(0.5, 0.5, 2.0), DVec3::new(0.6, -0.3, 0.4)), -1.0),
        (placed(cylinder, DVec3::new(0.5, 0.5, 2.0), DVec3::new(-0.9, 0.2, -0.4)), -1.0),
    ]
}

/// Intersection of a ray from the origin with the side of a shape that is seen, with the cosine there.
fn meets(quadric: &Quadric, side: f32, wi: Vec3) -> Option<(f32, f32)> {
    let mut hits = quadric.intersect(Vector::from(Vec3::ZERO), Vector::from(wi)).into_iter().filter(|&t| t > 0.0);
    hits.find_map(|t| {
        let cos = -quadric.point(quadric.uv(wi * t)).normal.dot(wi);
        (cos * side > 0.0).then_some((t, cos))
    })
}

#[test]
fn samples_of_quadrics_are_where_rays_meet_them_and_densities_are_those_of_their_directions() {
    let mut numbers = Numbers(5);
    for (quadric, side) in views() {
        let shape = Emitter::Quadric(quadric);
        // All directions, evenly: the solid angle, where it points, and what the density sums up to.
        let n = 1 << 20;
        let (mut towards, mut solid_angle, mut total) = (DVec3::ZERO, 0.0, 0.0);
        for i in 0..n {
            let u = [(f64::from(i) + 0.5) / f64::from(n), (f64::from(i) * 0.618_033_988_749_895).fract()];
            let wi = warp::uniform_sphere(u.map(|u| u as f32));
            let Some((t, cos)) = meets(&quadric, side, wi) else { continue };
            let part = 4.0 * std::f64::consts::PI / f64::from(n);
            solid_angle += part;
            towards += wi.as_dvec3() * part;
            total += f64::from(shape.pdf(Vec3::ZERO, t, cos).0) * part;
        }
        // The same by samples.
        let count = 100_000;
        let (mut sampled_towards, mut sampled) = (DVec3::ZERO, 0.0);
        for _ in 0..count {
            let Some(seen) = shape.sample(Vec3::ZERO, [numbers.next(), numbers.next()]) else { continue };
            let weight = 1.0 / f64::from(seen.pdf.0) / f64::from(count);
            sampled += weight;
            sampled_towards += seen.wi.as_dvec3() * weight;
            let distance = seen.point.position.length();
            let pdf = shape.pdf(Vec3::ZERO, distance, seen.cos).0;
            assert!((pdf / seen.pdf.0 - 1.0).abs() < 1e-4, "{quadric:?}: {pdf} {seen:?}");
            let cos = -seen.point.normal.dot(seen.wi);
            assert!((seen.cos - cos).abs() < 2e-3 && seen.cos * side > 0.0, "{quadric:?}: {cos} {seen:?}");
            assert!(
                (seen.point.position / distance - seen.wi).length() < 1e-4 + seen.point.error.length() / distance,
                "{quadric:?}: {seen:?}"
            );
        }
        // Of a million directions some 2000 meet the smallest, to a thousandth; of 10⁵ samples, whose densities differ by
        // a factor of a few, a hundredth is more than four standard errors.
        assert!((total - 1.0).abs() < 0.01, "{quadric:?} {side}: {total}");
        assert!((solid_angle - sampled).abs() < 0.01 * solid_angle, "{quadric:?} {side}: {solid_angle} {sampled}");
        let apart = (towards - sampled_towards).length();
        assert!(apart < 0.01 * solid_angle, "{quadric:?}: {towards} {sampled_towards}");
    }
}
