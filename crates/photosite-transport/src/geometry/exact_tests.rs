//! Hits against exact arithmetic: triangles of every aspect, size and distance, quadrics, instances and what moves, for
//! rays of cameras, rays to lights and rays that leave a surface.
//!
//! Numbers of f32 are taken as they are. In f64 they are exact to 2⁻⁵³, which is nothing beside u = 2⁻²⁴, the unit of
//! all tolerances here.

use glam::{Affine3A, DAffine3, DQuat, DVec2, DVec3, Quat, Vec3};

use super::accel_tests::{Numbers, geometry, in_world, mesh_of};
use super::mesh::interpolate;
use super::near_hit::is_slender;
use super::triangle_block::longest_axis;
use super::*;
use photosite_core::math::{Frame, warp};

const U: f64 = 0.5 * f32::EPSILON as f64;

/// Verdict of exact arithmetic on a ray and a triangle.
#[derive(Debug)]
enum Exact {
    /// Hit at t and at a point, with the errors that single precision may have.
    Hit {
        t: f64,
        t_error: f64,
        point: DVec3,
        point_error: f64,
    },
    Miss,
    /// Rounding decides, at an edge or in the plane of the triangle.
    Either,
}

/// Intersection of a line with a triangle by its plane.
fn exact(corners: [Vec3; 3], ray: &Ray) -> Exact {
    let is_slender = is_slender(&corners);
    let corners = corners.map(|corner| corner.as_dvec3());
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let z = longest_axis(ray.direction);
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let from_origin = corners.map(|corner| corner - o);
    let sheared = from_origin.map(|c| DVec2::new(c[x] - d[x] / d[z] * c[z], c[y] - d[y] / d[z] * c[z]));
    let areas = [0, 1, 2].map(|i| sheared[(i + 1) % 3].perp_dot(sheared[(i + 2) % 3]));
    let sum: f64 = areas.iter().sum();
    let largest = |numbers: [f64; 3]| numbers.into_iter().fold(0.0, f64::max);
    // A sheared coordinate is a difference, less the product of another one with a quotient: off by 5u of them and u of
    // itself. Areas are differences of products of such. A hundredth pays for products of errors.
    let reach = largest(from_origin.map(|c| c.abs().max_element()));
    let extent = largest(sheared.map(|p| p.abs().max_element()));
    let coordinate = (5.0 * reach + extent) * U;
    let area = 1.01 * 4.0 * extent * (coordinate + U * extent);
    if areas.iter().any(|a| *a > area) && areas.iter().any(|a| *a < -area) {
        return Exact::Miss;
    }
    // Corners are known to half a unit in the last place: nearer than that, an origin is in the plane.
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let farthest = corners.iter().fold(DVec3::ZERO, |far, corner| far.max(corner.abs()));
    let is_in_plane = from_origin[0].dot(normal).abs() <= 1.01 * U * normal.abs().dot(farthest);
    if is_in_plane || areas.iter().any(|a| a.abs() <= area) {
        return Exact::Either;
    }
    let weights = areas.map(|a| a / sum);
    let mean = |numbers: [f64; 3]| (0..3).map(|i| weights[i] * numbers[i]).sum::<f64>();
    let t = mean(from_origin.map(|c| c[z])) / d[z];
    if t < 0.0 {
        return Exact::Miss;
    }
    let point = o + d * t;
    // Weights are rounded to single precision, and so is their sum with the corners.
    let rounded = 8.0 * U * farthest.element_sum();
    if is_slender {
        return Exact::Hit { t, t_error: 2.0 * U * t, point, point_error: rounded };
    }
    let weight = 4.0 * area / (sum.abs() - 3.0 * area) + 4.0 * U;
    let longest = largest([0, 1, 2].map(|i| corners[(i + 1) % 3].distance(corners[i])));
    let deepest = largest(from_origin.map(|c| (c[z] / d[z]).abs()));
    Exact::Hit { t, t_error: (3.0 * weight + 8.0 * U) * deepest, point, point_error: 2.0 * weight * longest + rounded }
}

/// Whether exact arithmetic decides about a ray and a triangle, which then meet in each way of tracing or do not.
fn check(g: &Geometry, accels: &[Accel], ray: &Ray, id: u32, what: &str) -> bool {
    let expected = exact(g.corners(id), ray);
    for accel in accels {
        let (mut hits, mut occluded) = (vec![], vec![]);
        accel.closest_each(&[*ray], &AcceptAll, &mut hits);
        accel.occluded_each(&[*ray], &AcceptAll, &mut occluded);
        assert_eq!(occluded, [hits[0].is_some()], "{what}");
        match (&expected, hits[0]) {
            (Exact::Either, _) => return false,
            (&Exact::Hit { t, t_error, point, point_error }, Some(hit)) => {
                assert_eq!(hit.primitive, Primitive::Triangle(id), "{what}");
                assert!((f64::from(hit.t) - t).abs() <= t_error, "{what}: {} for {t} ± {t_error}", hit.t);
                let found = SurfacePoint::new(g, accel, &hit, 0.0).position.as_dvec3();
                assert!(
                    (found - point).abs().max_element() <= point_error,
                    "{what}: {found} for {point} ± {point_error}"
                );
                // To a lamp behind it and before it.
                for (end, is_occluded) in [(t + 2.0 * t_error, true), (t - 2.0 * t_error, false)] {
                    accel.occluded_each(&[Ray { t_max: end as f32, ..*ray }], &AcceptAll, &mut occluded);
                    assert!(end <= 0.0 || occluded == [is_occluded], "{what}: up to {end} of {t}");
                }
            }
            (Exact::Miss, None) => {}
            (expected, found) => panic!("{what}: {found:?} for {expected:?}, {ray:?}"),
        }
    }
    true
}

/// A triangle of a size and an aspect, anyhow turned, around the origin or some of its sizes away.
fn triangle(numbers: &mut Numbers, size: f32, aspect: f32) -> [Vec3; 3] {
    let frame = Frame::from_normal(warp::uniform_sphere([numbers.next(), numbers.next()]));
    let centre = (numbers.point() - 0.5) * 4.0 * size * (numbers.next() * 2.0).floor();
    let skew = numbers.next() * 2.0 - 1.0;
    [[-1.0, -1.0], [1.0, -1.0], [skew, 1.0]]
        .map(|[x, y]| centre + (frame.x * (x / aspect) + frame.y * y) * (0.5 * size))
}

/// The ways of tracing a few triangles: a scan, and a hierarchy.
fn both_ways(g: &Geometry) -> [Accel; 2] {
    let scanned = in_world(g);
    let mut hierarchy = scanned.clone();
    hierarchy.linear_scan = None;
    [scanned, hierarchy]
}

#[test]
fn triangles_of_every_aspect_and_size_are_met_where_exact_arithmetic_meets_them() {
    let mut numbers = Numbers(51);
    // By tens of the aspect, from anywhere and from another triangle.
    let mut decided = [[0; 5]; 2];
    for i in 0..12_000 {
        let (decade, size) = (numbers.next() * 5.0, 10f32.powf(8.0 * numbers.next() - 3.0));
        let other = 10f32.powf(numbers.next() * 5.0);
        let g = geometry(&[triangle(&mut numbers, size, 10f32.powf(decade)), triangle(&mut numbers, size, other)]);
        let target = interpolate(g.corners(0), [0.1 + 0.4 * numbers.next(), 0.1 + 0.4 * numbers.next()]);
        let distance = size * 10f32.powf(6.0 * numbers.next() - 4.0);
        let origin = target + warp::uniform_sphere([numbers.next(), numbers.next()]) * distance;
        let ray = Ray::new(origin, (target - origin) * (0.1 + numbers.next()));
        let what = format!("{i}: size {size}, aspect 10^{decade}, distance {distance}");
        let alone = geometry(&[g.corners(0)]);
        decided[0][decade as usize] += u32::from(check(&alone, &both_ways(&alone), &ray, 0, &what));

        let uv = [0.5 * numbers.next(), 0.5 * numbers.next()];
        let hit = Hit { t: 1.0, uv, primitive: Primitive::Triangle(1), instance: 0 };
        let accels = both_ways(&g);
        let point = SurfacePoint::new(&g, &accels[0], &hit, 0.0);
        let leaving = point.spawn_ray((target - point.position) * (0.1 + numbers.next()));
        decided[1][decade as usize] += u32::from(check(&g, &accels, &leaving, 0, &format!("{what}, scattered")));
    }
    println!("{decided:?}");
    assert!(decided.iter().flatten().all(|count| *count > 200), "{decided:?}");
}

/// Rectangles of an aspect side by side from `low` to `high` in a plane, each as two triangles, and those twice.
fn boards(aspect: f32, [low, high]: [f32; 2], turn: Quat) -> Vec<[Vec3; 3]> {
    let corner = |i: u8, y: f32| turn * Vec3::new(low + (high - low) * f32::from(i) / aspect, y, low);
    let board = |i: u8| {
        let (a, b, c, d) = (corner(i, low), corner(i + 1, low), corner(i + 1, high), corner(i, high));
        [[a, b, c], [a, c, d], [c, a, b], [c, d, a]]
    };
    (0..6).flat_map(board).collect()
}

#[test]
fn rays_that_leave_a_plane_do_not_meet_it_again() {
    let mut numbers = Numbers(17);
    let at = |scale: DVec3, turn: f64, place: f64| {
        let turn = DQuat::from_rotation_x(turn) * DQuat::from_rotation_z(0.7 * turn);
        DAffine3::from_scale_rotation_translation(scale, turn, DVec3::new(place, -place, 0.3 * place))
    };
    let still = |transform| InstanceTransform::Still(Transform::new(&transform));
    let moving = [at(DVec3::ONE, 0.2, 1.0), at(DVec3::new(1.5, 1.0, 1.0), 1.4, 5.0)];
    let transforms = [
        InstanceTransform::World,
        still(at(DVec3::new(2.0, 0.5, 1.0), 0.4, 3.0)),
        still(at(DVec3::new(-1.0, 1.0, 1e-3), 1.1, 100.0)),
        still(at(DVec3::splat(1e3), 0.8, 1e5)),
        still(at(DVec3::ONE, 0.0, 1e4)),
        InstanceTransform::Moving(Box::new(Motion::new(&moving))),
    ];
    for (aspect, place) in
        [(1.0, [0.0, 0.1]), (6.0, [3.0, 3.1]), (30.0, [-1.0, 1.0]), (1000.0, [-5e3, 5e3]), (6e4, [-0.5, 0.5])]
    {
        for (transform, tilt) in transforms.iter().map(|transform| (transform, 0.0)).chain([(&transforms[0], 0.6)]) {
            let turn = Quat::from_rotation_x(tilt) * Quat::from_rotation_z(0.7 * tilt);
            let g = geometry(&boards(aspect, place, turn));
            let count = g.triangles.len() as u32;
            // Where corners are rounded, boards lie askew by some u of their place over their width.
            let [low, high] = place;
            let askew = 8.0 * U as f32 * low.abs().max(high) * aspect / (high - low);
            let min_cosine = if tilt == 0.0 { 0.0 } else { askew };
            let instances = vec![Instance { blas: 0, transform: transform.clone() }; 2];
            let accel = Accel::build(&g, &[(0..count).into()], instances);
            let (mut met, mut shadowed) = (0, 0);
            for _ in 0..2000 {
                let time = numbers.next();
                let to_world = transform.at(time).map_or(Affine3A::IDENTITY, |there| there.to_world);
                let corners = g.corners((numbers.next() * count as f32) as u32);
                let b = [0.5 * numbers.next(), 0.5 * numbers.next()];
                let target = to_world.transform_point3(interpolate(corners, b));
                let along = [turn * Vec3::X, turn * Vec3::Y].map(|axis| to_world.transform_vector3(axis));
                let normal = along[0].cross(along[1]).normalize();
                let frame = Frame::from_normal(normal);
                let mut hemisphere =
                    || frame.to_world(warp::cosine_hemisphere([numbers.next(), numbers.next()]).into());
                let (eye, wi) = (target + hemisphere() * (high - low) * along[0].length(), hemisphere());
                let Some(hit) = accel.closest(&Ray::new(eye, target - eye).at_time(time), &AcceptAll) else { continue };
                if wi.dot(normal) < min_cosine {
                    continue;
                }
                met += 1;
                let point = SurfacePoint::new(&g, &accel, &hit, time);
                for side in [wi, -wi] {
                    // Directions need not be of unit length.
                    let ray = point.spawn_ray(side * 10f32.powf(6.0 * numbers.next() - 3.0));
                    shadowed += u32::from(accel.occluded(&ray, &AcceptAll));
                }
            }
            assert_eq!(shadowed, 0, "aspect {aspect}, {place:?}, tilt {tilt}, {transform:?}: of {met}");
            assert!(met > 200, "aspect {aspect}, {place:?}, tilt {tilt}, {transform:?}: {met}");
        }
    }
}

/// The t at which a line meets a unit shape, with the cosine there and whether an end or a rim is farther than a margin;
/// negative ones too.
fn roots(kind: QuadricKind, o: DVec3, d: DVec3, margin: f64) -> Option<Vec<(f64, f64)>> {
    let quadratic = |o: DVec3, d: DVec3| {
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
        let discriminant = b * b - a * c;
        // Where it grazes, rounding decides.
        let sine = (1.0 - discriminant / a).max(0.0).sqrt();
        ((sine - 1.0).abs() > 0.005).then(|| {
            let root = discriminant.max(0.0).sqrt();
            if discriminant < 0.0 { vec![] } else { vec![(-b - root) / a, (-b + root) / a] }
        })
    };
    let found = match kind {
        QuadricKind::Sphere => quadratic(o, d)?,
        QuadricKind::Cylinder => quadratic(o.with_z(0.0), d.with_z(0.0))?,
        QuadricKind::Disk => vec![-o.z / d.z],
    };
    let mut hits = vec![];
    for t in found {
        let p = o + d * t;
        let (normal, beyond) = match kind {
            QuadricKind::Sphere => (p, -1.0),
            QuadricKind::Cylinder => (p.with_z(0.0), (p.z - 0.5).abs() - 0.5),
            QuadricKind::Disk => (DVec3::Z, p.length() - 1.0),
        };
        let cos = normal.normalize().dot(d.normalize()).abs();
        if cos < 0.1 || beyond.abs() < margin / cos {
            return None;
        }
        if beyond < 0.0 {
            hits.push((t, cos));
        }
    }
    Some(hits)
}

#[test]
fn quadrics_of_every_size_are_met_where_exact_arithmetic_meets_them() {
    let mut numbers = Numbers(61);
    for kind in [QuadricKind::Sphere, QuadricKind::Disk, QuadricKind::Cylinder] {
        let mut decided = [0; 2];
        for i in 0..6000 {
            let size = 10f64.powf(8.0 * f64::from(numbers.next()) - 3.0);
            let axis = warp::uniform_sphere([numbers.next(), numbers.next()]).as_dvec3();
            let turn = DQuat::from_axis_angle(axis, 3.0 * f64::from(numbers.next()));
            let centre = ((numbers.point() - 0.5) * 4.0 * (numbers.next() * 2.0).floor()).as_dvec3() * size;
            let to_world = DAffine3::from_scale_rotation_translation(DVec3::splat(size), turn, centre);
            let to_object = to_world.inverse();
            let mut g = Geometry::default();
            g.meshes.push(MeshRange { quadric: Some(0), ..mesh_of(0) });
            g.quadrics.push(PlacedQuadric::new(kind, &to_world, 0));
            let accels = both_ways(&g);
            let towards = to_world.transform_point3((numbers.point() * 1.6 - 0.8).as_dvec3()).as_vec3();
            let distance = size as f32 * 10f32.powf(6.0 * numbers.next() - 4.0);
            let origin = towards + warp::uniform_sphere([numbers.next(), numbers.next()]) * distance;
            let camera = Ray::new(origin, (towards - origin) * (0.1 + numbers.next()));
            let scattered = accels[0].closest(&camera, &AcceptAll).map(|hit| {
                let point = SurfacePoint::new(&g, &accels[0], &hit, 0.0);
                point.spawn_ray(warp::uniform_sphere([numbers.next(), numbers.next()]) * (0.1 + numbers.next()))
            });
            for (ray, leaves) in [(Some(camera), false), (scattered, true)] {
                let Some(ray) = ray else { continue };
                let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
                // The centre is rounded, and some sixty times what is as large as the way to it: of that a height may be
                // off, and a distance by that over the cosine.
                let height = 64.0 * U * (centre.abs().element_sum() + o.distance(centre) + size);
                let (local_o, local_d) = (to_object.transform_point3(o), to_object.transform_vector3(d));
                let Some(roots) = roots(kind, local_o, local_d, height / size) else { continue };
                let error = |cos: f64| height / (cos * d.length());
                // The surface that the ray leaves is not met; a ray from elsewhere is not so near to one.
                let is_near = |&(t, cos): &(f64, f64)| t.abs() <= error(cos);
                if !leaves && roots.iter().any(is_near) {
                    continue;
                }
                decided[usize::from(leaves)] += 1;
                let expected = roots.iter().find(|root| root.0 > 0.0 && !is_near(root));
                let what = format!("{kind:?} {i}, leaves {leaves}: {ray:?}, {roots:?}");
                for accel in &accels {
                    let mut hits = vec![];
                    accel.closest_each(&[ray], &AcceptAll, &mut hits);
                    assert_eq!(
                        (hits[0].is_some(), hits[0].is_some()),
                        (expected.is_some(), accel.occluded(&ray, &AcceptAll)),
                        "{what}"
                    );
                    let (Some(hit), Some(&(t, cos))) = (hits[0], expected) else { continue };
                    assert!((f64::from(hit.t) - t).abs() <= error(cos) + 2.0 * U * t, "{what}: {}", hit.t);
                    let found = SurfacePoint::new(&g, accel, &hit, 0.0).position.as_dvec3();
                    assert!(found.distance(o + d * t) <= 2.0 * height / cos, "{what}: {found}");
                }
            }
        }
        println!("{kind:?} {decided:?}");
        assert!(decided[0] > 1000 && decided[1] > 500, "{kind:?}: {decided:?}");
    }
}
