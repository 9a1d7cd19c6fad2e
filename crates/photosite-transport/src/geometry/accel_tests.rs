//! Traversal against brute force, watertightness, instances, precision at every scale.

use glam::{Affine3A, DAffine3, DVec3, Quat, Vec3};

use super::*;
use photosite_core::math::hash::{hash64, unit_f32};
use photosite_core::math::warp;

/// A sequence of numbers in [0, 1) for a seed.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 += 1;
        unit_f32((hash64(1, self.0) >> 32) as u32)
    }

    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

pub(crate) fn geometry(triangles: &[[Vec3; 3]]) -> Geometry {
    let mut g = Geometry::default();
    for corners in triangles {
        let first = g.positions.len() as u32;
        g.positions.extend(corners);
        g.triangles.push(Triangle { corners: [first, first + 1, first + 2], mesh: 0 });
    }
    g.meshes.push(mesh_of(triangles.len() as u32));
    g
}

pub(crate) fn mesh_of(triangle_count: u32) -> MeshRange {
    MeshRange {
        material: 0,
        first_primitive: 0,
        first_triangle: 0,
        triangle_count,
        first_light: None,
        normals_from: None,
        tangents_from: None,
        uvs_from: [None; 2],
        colours_from: None,
        deformation: None,
        quadric: None,
    }
}

pub(crate) fn in_world(geometry: &Geometry) -> Accel {
    let all =
        PrimitiveRange { triangles: 0..geometry.triangles.len() as u32, quadrics: 0..geometry.quadrics.len() as u32 };
    Accel::build(geometry, &[all], vec![Instance { blas: 0, transform: InstanceTransform::World }])
}

/// A sphere of unit radius as a closed mesh of shared corners: latitude and longitude, with poles.
fn sphere(bands: u32, sectors: u32) -> Geometry {
    let mut g = Geometry::default();
    let corner = |band: u32, sector: u32| band * sectors + sector % sectors;
    for band in 0..=bands {
        for sector in 0..sectors {
            let theta = std::f32::consts::PI * band as f32 / bands as f32;
            let phi = std::f32::consts::TAU * sector as f32 / sectors as f32;
            // Exactly the same pole for every sector, or the mesh would not be closed there.
            let sin = if band == 0 || band == bands { 0.0 } else { theta.sin() };
            g.positions.push(Vec3::new(sin * phi.cos(), theta.cos(), sin * phi.sin()));
        }
    }
    for band in 0..bands {
        for sector in 0..sectors {
            let (a, b) = (corner(band, sector), corner(band, sector + 1));
            let (c, d) = (corner(band + 1, sector), corner(band + 1, sector + 1));
            for corners in [[a, b, c], [b, d, c]] {
                let [p, q, r] = corners.map(|i| g.positions[i as usize]);
                if p != q && q != r && r != p {
                    g.triangles.push(Triangle { corners, mesh: 0 });
                }
            }
        }
    }
    g.meshes.push(mesh_of(g.triangles.len() as u32));
    g
}

/// Möller–Trumbore in f64, as an independent reference.
fn brute_force(geometry: &Geometry, ray: &Ray) -> Option<(u32, f64)> {
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let hit = |i: u32| {
        let [a, b, c] = geometry.corners(i).map(|p| p.as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let p = d.cross(e2);
        let inverse = 1.0 / e1.dot(p);
        let u = (o - a).dot(p) * inverse;
        let q = (o - a).cross(e1);
        let (v, t) = (d.dot(q) * inverse, e2.dot(q) * inverse);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some((i, t))
    };
    (0..geometry.triangles.len() as u32).filter_map(hit).min_by(|a, b| a.1.total_cmp(&b.1))
}

#[test]
fn traversal_finds_what_brute_force_finds() {
    let mut numbers = Numbers(0);
    let soup: Vec<_> = (0..500)
        .map(|_| {
            let centre = numbers.point();
            [0, 1, 2].map(|_| centre + (numbers.point() - 0.5) * 0.2)
        })
        .collect();
    let g = geometry(&soup);
    let accel = in_world(&g);
    let (mut hits, mut differing) = (0, 0);
    for i in 0..4000 {
        let mut direction = warp::uniform_sphere([numbers.next(), numbers.next()]);
        if i % 4 == 0 {
            direction[i / 4 % 3] = if i % 8 == 0 { 0.0 } else { -0.0 };
        }
        let ray = Ray::new(numbers.point() * 2.0 - 0.5, direction);
        let expected = brute_force(&g, &ray);
        let found = accel.closest(&ray, &AcceptAll);
        assert_eq!(accel.occluded(&ray, &AcceptAll), found.is_some());
        hits += u32::from(expected.is_some());
        match (expected, found) {
            (Some((triangle, t)), Some(hit)) if Primitive::Triangle(triangle) == hit.primitive => {
                assert!((f64::from(hit.t) - t).abs() < 1e-4 * t.max(1e-2), "{t} {}", hit.t);
            }
            (None, None) => {}
            // Rays through an edge may be decided differently in f32.
            _ => differing += 1,
        }
    }
    assert!(hits > 400 && differing <= 2, "{hits} hits, {differing} differ");
}

/// Lets every other ray through every other primitive.
pub(crate) struct Sieve;

impl HitFilter for Sieve {
    fn accept(&self, primitive: Primitive, _: [f32; 2], ray: &Ray) -> bool {
        let (Primitive::Triangle(index) | Primitive::Quadric(index)) = primitive;
        (index ^ ray.direction.x.to_bits()) & 1 == 0
    }
}

/// Spheres in each other's way: of which one stays where it is, one is elsewhere, one moves, and one swells and
/// shrinks, here and there.
fn spheres() -> Accel {
    let mut g = sphere(16, 32);
    let (corners, triangles) = (g.positions.len() as u32, g.triangles.len() as u32);
    let shape = |size: f32| g.positions.iter().map(move |corner| corner * size);
    let positions: Vec<_> = [0.7, 1.2, 0.6].into_iter().flat_map(shape).collect();
    g.deformations.push(Deformation { first_corner: corners, corner_count: corners, positions, normals: vec![] });
    g.positions.extend_from_within(..);
    let moved: Vec<_> =
        g.triangles.iter().map(|t| Triangle { corners: t.corners.map(|c| c + corners), mesh: 1 }).collect();
    g.triangles.extend(moved);
    g.meshes.push(MeshRange { first_triangle: triangles, deformation: Some(0), ..mesh_of(triangles) });
    let at = |x: f64, y: f64| DAffine3::from_translation(DVec3::new(x, y, 0.0));
    let still = |x, y| InstanceTransform::Still(Transform::new(&at(x, y)));
    let instances = [
        (0, InstanceTransform::World),
        (0, still(-1.5, 0.0)),
        (0, InstanceTransform::Moving(Box::new(Motion::new(&[at(0.5, 0.0), at(2.0, 0.5)])))),
        (1, still(0.0, 1.0)),
        (1, InstanceTransform::World),
    ];
    let instances = instances.map(|(blas, transform)| Instance { blas, transform });
    Accel::build(&g, &[(0..triangles).into(), (triangles..2 * triangles).into()], instances.into())
}

#[test]
fn interleaved_rays_hit_what_each_hits_alone() {
    let mut numbers = Numbers(5);
    let g = sphere(16, 32);
    let nothing = Accel::build(&g, &[], vec![]);
    let as_if_large = |mut accel: Accel| {
        accel.exceeds_caches = true;
        accel
    };
    for (what, accel) in [
        ("in the world", in_world(&g)),
        ("as in a large mesh", as_if_large(in_world(&g))),
        ("instances as in large scenes", as_if_large(spheres())),
        ("nothing", nothing.clone()),
        ("nothing large", as_if_large(nothing)),
    ] {
        // More and fewer than are interleaved, and some that are short.
        for count in [0, 1, 7, 8, 9, 23, 24, 25, 300] {
            let ray = |i: usize| {
                let direction = warp::uniform_sphere([numbers.next(), numbers.next()]);
                let ray = Ray::new((numbers.point() - 0.5) * 5.0, direction).at_time(numbers.next());
                if i.is_multiple_of(3) { Ray { t_max: 1.5, ..ray } } else { ray }
            };
            let rays: Vec<Ray> = (0..count).map(ray).collect();
            let (mut hits, mut occluded) = (vec![None; 3], vec![true; 3]);
            accel.closest_each(&rays, &AcceptAll, &mut hits);
            let instances = accel.instances().len() as u32;
            let met = (0..instances).filter(|&instance| hits.iter().flatten().any(|hit| hit.instance == instance));
            assert!(count < 300 || met.count() == instances as usize, "{what}");
            accel.occluded_each(&rays, &AcceptAll, &mut occluded);
            assert_eq!(hits, rays.iter().map(|ray| accel.closest(ray, &AcceptAll)).collect::<Vec<_>>(), "{what}");
            assert_eq!(occluded, rays.iter().map(|ray| accel.occluded(ray, &AcceptAll)).collect::<Vec<_>>(), "{what}");
            accel.closest_each(&rays, &Sieve, &mut hits);
            accel.occluded_each(&rays, &Sieve, &mut occluded);
            assert_eq!(hits, rays.iter().map(|ray| accel.closest(ray, &Sieve)).collect::<Vec<_>>(), "{what}, sieve");
            assert_eq!(
                occluded,
                rays.iter().map(|ray| accel.occluded(ray, &Sieve)).collect::<Vec<_>>(),
                "{what}, sieve"
            );
        }
    }
}

/// A scene of triangles and spheres in each other's way, with the spheres.
pub(crate) fn mixed(numbers: &mut Numbers, triangles: usize, spheres: usize) -> (Geometry, Vec<Sphere>) {
    let soup: Vec<_> = (0..triangles)
        .map(|_| {
            let centre = numbers.point();
            [0, 1, 2].map(|_| centre + (numbers.point() - 0.5) * 0.3)
        })
        .collect();
    let mut g = geometry(&soup);
    let spheres: Vec<_> =
        (0..spheres).map(|_| Sphere { centre: numbers.point(), radius: 0.02 + 0.1 * numbers.next() }).collect();
    for &sphere in &spheres {
        let mesh = g.meshes.len() as u32;
        let bounds = (sphere.centre - sphere.radius, sphere.centre + sphere.radius);
        g.meshes.push(MeshRange { quadric: Some(g.quadrics.len() as u32), ..mesh_of(0) });
        g.quadrics.push(PlacedQuadric { quadric: Quadric::Sphere(sphere), mesh, bounds });
    }
    (g, spheres)
}

/// The nearest of triangles and spheres in f64.
fn brute_force_mixed(g: &Geometry, spheres: &[Sphere], ray: &Ray) -> Option<(Primitive, f64)> {
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let of_spheres = (0..).map(Primitive::Quadric).zip(spheres).flat_map(|(id, sphere)| {
        let f = o - sphere.centre.as_dvec3();
        let (a, b, c) = (d.dot(d), f.dot(d), f.dot(f) - f64::from(sphere.radius).powi(2));
        let root = (b * b - a * c).sqrt();
        [(-b - root) / a, (-b + root) / a].map(|t| (id, t))
    });
    let nearest = of_spheres.filter(|&(_, t)| t > 0.0);
    let of_triangles = brute_force(g, ray).map(|(triangle, t)| (Primitive::Triangle(triangle), t));
    nearest.chain(of_triangles).min_by(|a, b| a.1.total_cmp(&b.1))
}

#[test]
fn spheres_are_met_among_triangles() {
    let mut numbers = Numbers(23);
    for (triangles, spheres) in [(10, 3), (0, 4), (300, 200), (0, 1)] {
        let (g, spheres) = mixed(&mut numbers, triangles, spheres);
        let accel = in_world(&g);
        let rays: Vec<_> = (0..3000)
            .map(|_| {
                let direction = warp::uniform_sphere([numbers.next(), numbers.next()]) * (0.1 + numbers.next());
                Ray::new(numbers.point() * 1.4 - 0.2, direction)
            })
            .collect();
        let (mut hits, mut occluded) = (vec![], vec![]);
        accel.closest_each(&rays, &AcceptAll, &mut hits);
        accel.occluded_each(&rays, &AcceptAll, &mut occluded);
        let (mut on_spheres, mut differing) = (0, 0);
        for ((ray, hit), occluded) in rays.iter().zip(&hits).zip(occluded) {
            assert_eq!(occluded, hit.is_some());
            match (brute_force_mixed(&g, &spheres, ray), hit) {
                (Some((primitive, t)), Some(hit)) if primitive == hit.primitive => {
                    assert!((f64::from(hit.t) - t).abs() < 1e-4 * t.max(1e-1), "{t} {}", hit.t);
                    let point = SurfacePoint::new(&g, &accel, hit, 0.0);
                    let tolerance = 1e-5 + 4.0 * point.error.max_element();
                    assert!((point.position - ray.at(hit.t)).length() < tolerance, "{point:?}");
                    on_spheres += u32::from(g.meshes[point.mesh as usize].quadric.is_some());
                }
                (None, None) => {}
                // Rays through an edge or at the rim may be decided differently in f32.
                _ => differing += 1,
            }
        }
        assert!(on_spheres > 5 && differing <= 3, "{triangles}: {on_spheres} on spheres, {differing} differ");
    }
}

#[test]
fn no_ray_leaves_a_closed_mesh_at_any_scale_or_place() {
    let mut numbers = Numbers(7);
    for (scale, offset) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1000.0)] {
        let mut g = sphere(24, 48);
        g.positions.iter_mut().for_each(|p| *p = *p * scale + offset);
        let accel = in_world(&g);
        for i in 0..20_000 {
            // Half of the rays aim exactly at a corner or at the middle of an edge, where leaks are.
            let triangle = (numbers.next() * g.triangles.len() as f32) as u32;
            let [a, b, _] = g.corners(triangle.min(g.triangles.len() as u32 - 1));
            let origin = (numbers.point() - 0.5) * scale * 0.5 + offset;
            let direction = match i % 4 {
                0 => a - origin,
                1 => (a + b) * 0.5 - origin,
                2 => Vec3::AXES[i / 4 % 3] * if i % 8 == 2 { 1.0 } else { -1.0 },
                _ => warp::uniform_sphere([numbers.next(), numbers.next()]),
            };
            let ray = Ray::new(origin, direction);
            assert!(accel.closest(&ray, &AcceptAll).is_some(), "scale {scale} offset {offset}: {ray:?}");
        }
    }
}

#[test]
fn a_mesh_built_in_chunks_is_met_as_its_parts_are() {
    let mut numbers = Numbers(11);
    let g = sphere(200, 400);
    let count = g.triangles.len() as u32;
    let in_parts = [0, 1, 2, 3].map(|i| count * i / 4..count * (i + 1) / 4);
    let instances = (0..4).map(|blas| Instance { blas, transform: InstanceTransform::World }).collect();
    let (whole, parts) = (in_world(&g), Accel::build(&g, &in_parts.map(PrimitiveRange::from), instances));
    assert_eq!(whole.bounds(), parts.bounds());
    for _ in 0..5_000 {
        let direction = warp::uniform_sphere([numbers.next(), numbers.next()]);
        let ray = Ray::new((numbers.point() - 0.5) * 3.0, direction);
        let distance = |accel: &Accel| accel.closest(&ray, &AcceptAll).map(|hit| hit.t);
        assert_eq!(distance(&whole), distance(&parts), "{ray:?}");
        assert_eq!(whole.occluded(&ray, &AcceptAll), distance(&parts).is_some(), "{ray:?}");
    }
}

#[test]
fn rays_that_leave_a_surface_do_not_meet_it_again() {
    let mut numbers = Numbers(3);
    let g = sphere(24, 48);
    let transform = Affine3A::from_scale_rotation_translation(
        Vec3::new(2.0, 0.5, 1.0),
        Quat::from_rotation_y(0.7),
        Vec3::new(100.0, -50.0, 3.0),
    );
    let placed = Instance {
        blas: 0,
        transform: InstanceTransform::Still(Transform { to_world: transform, to_object: transform.inverse() }),
    };
    let all = 0..g.triangles.len() as u32;
    for accel in [in_world(&g), Accel::build(&g, &[all.into()], vec![placed])] {
        let (low, high) = accel.bounds();
        let centre = (low + high) * 0.5;
        for _ in 0..20_000 {
            let ray = Ray::new(centre, warp::uniform_sphere([numbers.next(), numbers.next()]));
            let hit = accel.closest(&ray, &AcceptAll).expect("inside a closed mesh");
            let point = SurfacePoint::new(&g, &accel, &hit, 0.0);
            assert!((point.position - ray.at(hit.t)).length() < 1e-3);
            // Outwards from a convex body there is nothing more to meet.
            let outward = point.geometric_normal * ray.direction.dot(point.geometric_normal).signum();
            let grazing = (outward + 0.999 * warp::uniform_sphere([numbers.next(), numbers.next()])).normalize();
            let leaving = Ray { direction: grazing, ..point.spawn_ray(outward) };
            let again = accel.closest(&leaving, &AcceptAll);
            assert!(again.is_none(), "{leaving:?} {again:?}");
        }
    }
}

#[test]
fn instances_stand_where_their_transforms_put_them() {
    let g = sphere(16, 32);
    let at = |x: f32, scale: f32| {
        let to_world = Affine3A::from_scale_rotation_translation(Vec3::splat(scale), Quat::IDENTITY, Vec3::X * x);
        Instance { blas: 0, transform: InstanceTransform::Still(Transform { to_world, to_object: to_world.inverse() }) }
    };
    let instances: Vec<_> = (0..40).map(|i| at(4.0 * i as f32, if i % 2 == 0 { 1.0 } else { 0.5 })).collect();
    let all = 0..g.triangles.len() as u32;
    let accel = Accel::build(&g, &[all.into()], instances);
    for i in 0..40 {
        let hit = accel.closest(&Ray::new(Vec3::new(4.0 * i as f32 + 0.1, 5.0, 0.1), Vec3::NEG_Y), &AcceptAll);
        let hit = hit.expect("straight above a sphere");
        assert_eq!(hit.instance, i);
        let point = SurfacePoint::new(&g, &accel, &hit, 0.0);
        let radius = if i % 2 == 0 { 1.0 } else { 0.5 };
        let from_centre = point.position - Vec3::X * 4.0 * i as f32;
        // The chord of a 16-band sphere lies at most 1 − cos(π/32) ≈ 0.5 % inside it.
        assert!((from_centre.length() / radius - 1.0).abs() < 0.012, "{from_centre}");
        assert!(point.geometric_normal.dot(from_centre.normalize()).abs() > 0.98);
    }
    assert!(accel.closest(&Ray::new(Vec3::new(2.0, 5.0, 0.0), Vec3::NEG_Y), &AcceptAll).is_none());
}

#[test]
fn tiny_trees_are_trees_too() {
    for count in 1..20 {
        let column: Vec<_> = (0..count)
            .map(|i| [Vec3::new(-1.0, i as f32, -1.0), Vec3::new(1.0, i as f32, -1.0), Vec3::new(0.0, i as f32, 1.0)])
            .collect();
        let g = geometry(&column);
        let accel = in_world(&g);
        let hit = accel.closest(&Ray::new(Vec3::new(0.0, 100.0, 0.0), Vec3::NEG_Y), &AcceptAll).expect("a hit");
        assert_eq!(
            (hit.primitive, hit.t),
            (Primitive::Triangle(count - 1), 100.0 - (count - 1) as f32),
            "{count} triangles"
        );
    }
}

#[test]
fn a_road_of_any_length_is_seen_along() {
    for [width, length] in [[10.0f32, 1e4], [1.0, 3e3], [10.0, 1e5], [0.1, 1e3]] {
        for turn in [0.0f32, 0.4, 0.785] {
            let turn = Quat::from_rotation_z(turn);
            let corner = |x: f32, y: f32| turn * Vec3::new(0.5 * x * width, 0.5 * y * length, 0.0);
            let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
            let g = geometry(&[[a, b, c], [a, c, d]]);
            let accel = in_world(&g);
            for distance in [2.0f32, 15.0, 60.0, 0.3 * length] {
                let target = turn * Vec3::new(0.1 * width, distance, 0.0);
                let ray = Ray::new(Vec3::Z * 1.5, target - Vec3::Z * 1.5);
                let hit = accel.closest(&ray, &AcceptAll);
                assert!(hit.is_some_and(|hit| hit.t > 0.0), "{width} × {length}, {distance}");
                let mut hits = vec![];
                accel.closest_each(&[ray], &AcceptAll, &mut hits);
                assert_eq!(hits[0], hit, "{width} × {length}, {distance}");
            }
        }
    }
}
