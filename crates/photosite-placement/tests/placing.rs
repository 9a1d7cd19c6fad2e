//! Placement of objects: their positions, that none meets another, that the same seed gives the same poses.

use std::sync::Arc;
use std::thread;

use glam::{DQuat, DVec3};
use photosite_placement::{
    Bin, Contact, Fixed, Item, Method, Pose, Region, Request, Shape, Support, Turn, cuboid, place,
};

#[path = "../examples/draws/shapes.rs"]
mod shapes;

fn shape((positions, triangles): shapes::Mesh) -> Arc<Shape> {
    Arc::new(Shape::new(&positions, &triangles).expect("a shape"))
}

fn cube(side: f64) -> Arc<Shape> {
    shape(cuboid(DVec3::splat(-side / 2.0), DVec3::splat(side / 2.0)))
}

fn region(min: [f64; 3], max: [f64; 3]) -> Region {
    Region { min: min.into(), max: max.into() }
}

fn request(items: Vec<Arc<Shape>>, how: Method) -> Request {
    Request {
        items: items.into_iter().map(Item::new).collect(),
        how,
        fixed: Vec::new(),
        ground_height_m: Some(0.0),
        min_distance_m: 0.0,
        contact: Contact::default(),
        seed: 1,
    }
}

fn corners(pose: &Pose, side: f64) -> Vec<DVec3> {
    cuboid(DVec3::splat(-side / 2.0), DVec3::splat(side / 2.0)).0.iter().map(|p| pose.point(*p)).collect()
}

/// Angle from the vertical to the most vertical of the object's own axes.
fn tilt(rotation: DQuat) -> f64 {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (rotation * axis).y.abs());
    axes.into_iter().fold(0.0, f64::max).acos()
}

#[test]
fn a_box_stands_on_each_of_its_faces() {
    let shape = shape(cuboid(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)));
    let poses = shape.resting_poses();
    assert_eq!(poses.len(), 6);
    assert!((poses.iter().map(|pose| pose.probability).sum::<f64>() - 1.0).abs() < 1e-12);
    // The solid angle of a rectangle of half sides a and b at a distance d.
    let expected = |a: f64, b: f64, d: f64| {
        (a * b / ((a * a + d * d) * (b * b + d * d)).sqrt()).asin() * 4.0 / (4.0 * std::f64::consts::PI)
    };
    let sides = [[0.5, 1.0, 1.5], [0.5, 1.5, 1.0], [1.0, 1.5, 0.5]].map(|[a, b, d]| expected(a, b, d));
    let mut sides: Vec<f64> = sides.iter().flat_map(|p| [*p, *p]).collect();
    sides.sort_by(|a, b| b.total_cmp(a));
    for (pose, expected) in poses.iter().zip(sides) {
        assert!((pose.probability - expected).abs() < 1e-12, "{} {expected}", pose.probability);
        assert!(tilt(pose.rotation) < 1e-7);
    }
}

#[test]
fn a_leaning_prism_rolls_off_the_face_that_does_not_hold_it() {
    // Its centre of mass lies beyond the edge of its smaller base.
    let profile = [(0.0, 0.0), (1.0, 0.0), (6.0, 4.0), (3.0, 4.0)];
    let positions: Vec<DVec3> = [0.0, 2.0].iter().flat_map(|z| profile.map(|(x, y)| DVec3::new(x, y, *z))).collect();
    let mut triangles = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
    for i in 0..4 {
        let j = (i + 1) % 4;
        triangles.extend([[i, j, j + 4], [i, j + 4, i + 4]]);
    }
    let shape = Shape::new(&positions, &triangles).expect("a shape");
    assert!(shape.centre_of_mass().x > 1.0);
    let downs = || shape.resting_poses().iter().map(|pose| pose.rotation.inverse() * DVec3::NEG_Y);
    assert!(downs().all(|down| down.distance(DVec3::NEG_Y) > 1e-3), "it does not stand on y = 0");
    assert!((shape.resting_poses().iter().map(|pose| pose.probability).sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn standing_objects_touch_the_ground_and_lie_in_the_region() {
    let all: Vec<Arc<Shape>> = shapes::all().into_iter().map(|(_, mesh)| shape(mesh)).collect();
    let meshes: Vec<shapes::Mesh> = shapes::all().into_iter().map(|(_, mesh)| mesh).collect();
    let area = region([-0.4, 0.0, -0.3], [0.4, 0.0, 0.3]);
    let poses = place(&request(all.clone(), Method::Rest { on: Support::Ground(area) })).expect("places");
    for ((pose, (positions, _)), shape) in poses.iter().zip(&meshes).zip(&all) {
        let lowest = positions.iter().map(|p| pose.point(*p).y).fold(f64::INFINITY, f64::min);
        assert!((0.0..1e-6).contains(&lowest), "{lowest}");
        let centre = pose.point(shape.centre_of_mass());
        assert!(centre.x.abs() <= 0.4 && centre.z.abs() <= 0.3);
    }
}

#[test]
fn dropped_cubes_lie_on_the_ground_or_on_each_other() {
    let side = 0.05;
    let how = Method::Drop { region: region([-0.2, 0.0, -0.2], [0.2, 0.2, 0.2]), keep_in: None };
    let poses = place(&request(vec![cube(side); 4], how)).expect("places");
    for pose in &poses {
        let lowest = corners(pose, side).iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        // On a face, with the engine's gap under it, unless it leans on another.
        if tilt(pose.rotation) < 1e-3 && pose.position.y < side {
            assert!((0.0..1e-4).contains(&lowest), "{lowest}");
            assert!((pose.position.y - side / 2.0).abs() < 1e-4);
        }
    }
    assert!(poses.iter().filter(|pose| tilt(pose.rotation) < 1e-3).count() >= 3);
}

#[test]
fn a_stack_stands_one_upon_the_other() {
    let sides = [0.08, 0.06, 0.05];
    let items = sides.iter().map(|side| cube(*side)).collect();
    let poses = place(&request(items, Method::Stack { position: DVec3::new(0.3, 0.0, -0.2) })).expect("a stack");
    let mut height = 0.0;
    for (pose, side) in poses.iter().zip(sides) {
        // Each contact has a gap of at most a tenth of a millimetre.
        let bottom = pose.position.y - side / 2.0;
        assert!((height..height + 1e-4).contains(&bottom), "{bottom} on {height}");
        height = pose.position.y + side / 2.0;
        assert!((pose.position.x - 0.3).abs() < 1e-3 && (pose.position.z + 0.2).abs() < 1e-3);
    }
}

#[test]
fn objects_in_a_bin_stay_between_its_walls() {
    let bin = Bin { size: DVec3::new(0.2, 0.1, 0.15), position: DVec3::new(1.0, 0.5, 0.0), wall: 0.005 };
    let how = Method::Drop { region: bin.region(), keep_in: Some(bin.inside()) };
    let request =
        Request { fixed: bin.fixed().expect("walls"), ground_height_m: None, ..request(vec![cube(0.04); 6], how) };
    let poses = place(&request).expect("places");
    for corner in poses.iter().flat_map(|pose| corners(pose, 0.04)) {
        assert!((corner.x - 1.0).abs() <= 0.1 && corner.z.abs() <= 0.075, "{corner}");
        assert!(corner.y >= 0.5, "{corner}");
    }
    let (positions, triangles) = bin.mesh();
    let volume: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    let expected = 0.21 * 0.105 * 0.16 - 0.2 * 0.1 * 0.15;
    assert!((volume - expected).abs() < 1e-12, "{volume} {expected}");
}

#[test]
fn the_same_seed_gives_the_same_on_any_thread_and_another_seed_another() {
    let all: Vec<Arc<Shape>> = shapes::all().into_iter().map(|(_, mesh)| shape(mesh)).collect();
    let how = Method::Drop { region: region([-0.1, 0.0, -0.1], [0.1, 0.2, 0.1]), keep_in: None };
    let request = request(all, how);
    let first = place(&request).expect("places");
    let again = thread::scope(|scope| {
        let threads: Vec<_> = (0..2).map(|_| scope.spawn(|| place(&request).expect("places"))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect::<Vec<_>>()
    });
    assert!(again.iter().all(|poses| *poses == first));
    assert_ne!(place(&Request { seed: 2, ..request }).expect("places"), first);
}

#[test]
fn objects_in_a_box_keep_their_distance() {
    let how = Method::Box { region: region([0.0; 3], [0.3; 3]), turn: Turn::None };
    let request = Request { ground_height_m: None, min_distance_m: 0.02, ..request(vec![cube(0.04); 20], how) };
    let poses = place(&request).expect("places");
    for (i, a) in poses.iter().enumerate() {
        for b in &poses[..i] {
            // Without a turn, cubes are as far apart as their faces, edges or corners.
            let apart = ((a.position - b.position).abs() - DVec3::splat(0.04)).max(DVec3::ZERO).length();
            assert!(apart >= 0.02 - 1e-9, "{apart}");
        }
    }
}

#[test]
fn one_inside_the_other_is_no_place() {
    let shell = shape(cuboid(DVec3::splat(-0.5), DVec3::splat(0.5)));
    let how = Method::Box { region: region([-0.3; 3], [0.3; 3]), turn: Turn::Any };
    let fixed = vec![Fixed { shape: shell, scale: 1.0, pose: Pose::IDENTITY }];
    let request = Request { fixed, ground_height_m: None, ..request(vec![cube(0.1)], how) };
    let error = place(&request).expect_err("no room");
    assert!(error.message.starts_with("0 of 1 objects find room"), "{error}");
}

#[test]
fn surfaces_are_touched_over_their_whole_area() {
    let table = Fixed {
        shape: shape(cuboid(DVec3::new(-1.0, 0.6, -0.5), DVec3::new(1.0, 0.7, 0.5))),
        scale: 1.0,
        pose: Pose::IDENTITY,
    };
    let how = Method::Surface { on: 0, turn: Turn::Any };
    let request = Request { fixed: vec![table], ..request(vec![cube(0.04); 60], how) };
    let poses = place(&request).expect("places");
    let mut means = DVec3::ZERO;
    for pose in &poses {
        let lowest = corners(pose, 0.04).iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        assert!((0.7 - 1e-9..0.7 + 1e-6).contains(&lowest), "{lowest}");
        means += pose.position.abs() / poses.len() as f64;
    }
    // Five standard deviations of the mean of 60 even numbers.
    assert!((means.x - 0.5).abs() < 5.0 * 0.289 / 60f64.sqrt() && (means.z - 0.25).abs() < 2.5 * 0.289 / 60f64.sqrt());
}

#[test]
fn what_cannot_be_is_said() {
    let empty = Shape::new(&[DVec3::ZERO; 3], &[[0, 1, 2]]).expect_err("no area");
    assert_eq!(empty.message, "the mesh has no surface");
    assert!(Shape::new(&[DVec3::NAN; 3], &[[0, 1, 2]]).is_err());
    assert!(Shape::new(&[DVec3::ZERO; 3], &[[0, 1, 3]]).is_err());
    let how = || Method::Drop { region: region([0.0; 3], [0.1; 3]), keep_in: None };
    let floating = Request { ground_height_m: None, ..request(vec![cube(0.1)], how()) };
    assert_eq!(place(&floating).expect_err("no ground").key, "ground_height_m");
    let mut small = request(vec![cube(0.1)], how());
    small.items[0].scale = 0.0;
    assert_eq!(place(&small).expect_err("no size").key, "scale");
    let crowded = request(vec![cube(0.1); 30], Method::Rest { on: Support::Ground(region([0.0; 3], [0.3; 3])) });
    let error = place(&crowded).expect_err("no room");
    assert!(error.message.contains("of 30 objects find room"), "{error}");
}

#[test]
fn sheets_and_open_meshes_have_places() {
    // A sheet, and half a cube without the rest.
    let (positions, triangles) = cuboid(DVec3::ZERO, DVec3::splat(0.05));
    let half = Arc::new(Shape::new(&positions, &triangles[..6]).expect("a shape"));
    let sheet = shape(shapes::card(0.08, 0.05));
    let how = Method::Drop { region: region([-0.2, 0.0, -0.2], [0.2, 0.1, 0.2]), keep_in: None };
    let poses = place(&request(vec![half, sheet], how)).expect("places");
    let lowest = shapes::card(0.08, 0.05).0.iter().map(|p| poses[1].point(*p).y).fold(f64::INFINITY, f64::min);
    assert!((0.0..1e-4).contains(&lowest), "{lowest}");
}
