//! Ground truth against closed forms: planes, moving cameras, hidden surfaces, reflectances.

use glam::{DAffine3, DVec2, DVec3, Vec3};
use photosite::calibration::truth::{TruthJob, TruthLayer, View, truth};
use photosite::colour::ColourSpace;
use photosite::geometry::Trajectory;
use photosite::image::Planes;
use photosite::optics::{Camera, Focus, LensDescription, LensKind, PixelGrid, Recording};
use photosite::scene::Scene;
use photosite::scene::description::{Colour, Diffuse, MaterialModel, TexturedColour};
use photosite::spectrum::{Spectrum, cie, illuminant};
use rstest::rstest;

use crate::stage::{Stage, camera, square};

const RESOLUTION: [u32; 2] = [64, 48];
/// Focal length in pixels.
const FX: f64 = 80.0;
/// Coordinates of a metre or two, projected with `FX`: a dozen roundings of f32, in pixels.
const ROUNDING_PX: f64 = 12.0 * FX * f32::EPSILON as f64 * 2.0;

fn pinhole(to_world: DAffine3) -> Camera {
    let lens = LensDescription { kind: LensKind::Pinhole, ..LensDescription::thin(2e-3, 8.0, Focus::Infinity) };
    camera(&lens, &PixelGrid { resolution: RESOLUTION, pitch_m: [2e-3 / FX; 2] }, to_world)
}

/// Direction in camera space, z = −1, of the ray through the centre of a pixel.
fn direction(x: usize, y: usize) -> DVec3 {
    let [width, height] = RESOLUTION.map(f64::from);
    DVec3::new((x as f64 + 0.5 - width / 2.0) / FX, -(y as f64 + 0.5 - height / 2.0) / FX, -1.0)
}

/// With flow to an image of another scene.
fn ask_of([scene, later]: [&Scene; 2], [camera, next]: [&Camera; 2], layers: &[TruthLayer]) -> Planes {
    let [view, next] = [(scene, camera), (later, next)].map(|(scene, camera)| View::of(scene, camera, RESOLUTION));
    truth(&TruthJob { view, objects: &[], next: Some(next), partner: None }, layers)
}

fn ask(scene: &Scene, camera: &Camera, next: &Camera, layers: &[TruthLayer]) -> Planes {
    ask_of([scene, scene], [camera, next], layers)
}

fn pixels() -> impl Iterator<Item = (usize, usize, usize)> {
    let [width, height] = RESOLUTION.map(|n| n as usize);
    (0..width * height).map(move |i| (i, i % width, i / width))
}

fn value(planes: &Planes, name: &str, i: usize) -> f64 {
    f64::from(planes.plane(name).unwrap_or_else(|| panic!("no plane {name}"))[i])
}

fn vector(planes: &Planes, name: &str, i: usize) -> DVec3 {
    DVec3::from_array(["X", "Y", "Z"].map(|axis| value(planes, &format!("{name}.{axis}"), i)))
}

/// A wall 2 m in front of the origin, 8 m wide.
fn wall() -> Stage {
    Stage::default().diffuse(square(Vec3::new(0.0, 0.0, -2.0), Vec3::X, Vec3::Y, 4.0), 0.5, 0.0)
}

#[rstest]
#[case::upright(0.0, 0.0)]
#[case::tilted(0.4, -0.3)]
fn a_plane_is_where_the_rays_meet_it(#[case] about_x: f64, #[case] about_y: f64) {
    let to_world = DAffine3::from_translation(DVec3::new(0.1, -0.2, 0.3))
        * DAffine3::from_rotation_x(about_x)
        * DAffine3::from_rotation_y(about_y);
    let camera = pinhole(to_world);
    let layers = [TruthLayer::Depth, TruthLayer::Distance, TruthLayer::Position, TruthLayer::Normal];
    let planes = ask(&wall().build(), &camera, &camera, &layers);
    for (i, x, y) in pixels() {
        let ray = direction(x, y);
        let along = to_world.matrix3 * ray;
        // The plane z = −2; the ray's parameter is the depth, as its z in camera space is −1.
        let depth = (-2.0 - to_world.translation.z) / along.z;
        let position = to_world.translation + along * depth;
        let error = 16.0 * f64::from(f32::EPSILON) * (1.0 + position.length());
        assert!((value(&planes, "depth", i) - depth).abs() < error, "{x}, {y}: {depth}");
        assert!((value(&planes, "distance", i) - depth * ray.length()).abs() < error, "{x}, {y}");
        // Obliquely, an error of the ray's direction shows magnified along the plane.
        let oblique = along.length() / along.z.abs();
        assert!((vector(&planes, "position", i) - position).length() < error * oblique, "{x}, {y}: {position}");
        assert_eq!(vector(&planes, "normal", i), DVec3::Z, "{x}, {y}");
    }
}

/// The camera of image `number` of a series, rows one after the other where `row_time_s` is not 0.
fn moving(velocity_m_per_s: DVec3, row_time_s: f64, number: u32) -> Camera {
    let motion = Trajectory::Steady { velocity_m_per_s, angular_velocity_rad_per_s: DVec3::ZERO };
    let recording = Recording {
        motion: Some(motion),
        start_s: 0.0,
        exposure_s: 2e-3,
        row_time_s,
        first_row: 0.0,
        duration_s: 1.0,
        frame_interval_s: 0.1,
    };
    pinhole(DAffine3::IDENTITY).recording(recording.later(number))
}

#[rstest]
fn flow_is_that_of_a_passing_wall(
    #[values([1.0, 0.0], [0.0, 1.0], [0.5, -0.8])] velocity: [f64; 2],
    #[values(0.0, 1e-3)] row_time_s: f64,
) {
    let [vx, vy] = velocity;
    let [camera, next] = [0, 1].map(|number| moving(DVec3::new(vx, vy, 0.0), row_time_s, number));
    let planes = ask(&wall().build(), &camera, &next, &[TruthLayer::Flow]);
    // A camera that rises sees things sink: by s = f·v/z rows a second. A point's row solves
    // y = y₀ + s·(k·T + y·t_row), so that it is s·T/(1 − s·t_row) lower in the next image; it is seen so much later,
    // too.
    let speed = FX * vy / 2.0;
    let down = speed * 0.1 / (1.0 - speed * row_time_s);
    let expected = DVec2::new(-FX * vx / 2.0 * (0.1 + down * row_time_s), down);
    for (i, x, y) in pixels() {
        let flow = DVec2::new(value(&planes, "flow.X", i), value(&planes, "flow.Y", i));
        assert!((flow - expected).length() < ROUNDING_PX, "{x}, {y}: {flow}, not {expected}");
        let to = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) + expected;
        let inside = to.x >= 0.0 && to.y >= 0.0 && to.x < f64::from(RESOLUTION[0]) && to.y < f64::from(RESOLUTION[1]);
        assert_eq!(value(&planes, "flow.visible", i) == 1.0, inside, "{x}, {y}");
    }
}

/// The row of pixels of a line camera looks straight ahead, so that a point is on the line at whose middle the camera
/// stands at its height: −v·(n·t_row + ½·t_exposure) = Y.
#[test]
fn a_line_camera_sees_points_at_the_line_that_they_come_to() {
    let (speed, row_time_s) = (2.0, 1e-2);
    let recording = moving(DVec3::new(0.0, -speed, 0.0), row_time_s, 0);
    let lens = LensDescription { kind: LensKind::Pinhole, ..LensDescription::thin(2e-3, 8.0, Focus::Infinity) };
    let row = PixelGrid { resolution: [RESOLUTION[0], 1], pitch_m: [2e-3 / FX; 2] };
    let line_camera = camera(&lens, &row, DAffine3::IDENTITY).moving_as(&recording).scanning();
    let scene = wall().build();
    let view = View::of(&scene, &line_camera, RESOLUTION);
    for (x, y) in [(0.3, -0.1), (-0.5, -0.44), (0.0, -0.9), (0.2, 0.5)] {
        let line = (-y / speed - 1e-3) / row_time_s;
        let found = view.project(DVec3::new(x, y, -2.0)).expect("comes by");
        let expected = DVec2::new(32.0 + FX * x / 2.0, line + 0.5);
        // Secants end within 1e-9 rows; the camera moves by FX·v·t_row/z, 0.8 rows, from line to line.
        assert!((found - expected).length() < 1e-8, "{found} for {expected}");
    }
}

/// d = fx·b/z, positive for both cameras of a pair: the left one finds the point d to the left in the other image,
/// the right one d to the right.
#[rstest]
fn disparity_is_that_of_a_parallel_pair(
    #[values(0.0, 1e-3)] row_time_s: f64,
    #[values(DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y)] towards_partner: DVec3,
) {
    let baseline = 0.12;
    // Both stand on the same base: where it moves, and rows are exposed one after the other, a point is still in the
    // same row of both, if they stand side by side.
    let level = towards_partner.y == 0.0;
    let camera = moving(DVec3::new(0.3, 0.4, 0.0), if level { row_time_s } else { 0.0 }, 2);
    let place = DAffine3::from_translation(towards_partner * baseline);
    let (scene, resolution) = (wall().build(), RESOLUTION);
    let view = View::of(&scene, &camera, resolution);
    let partner = View { place, ..view };
    let job = TruthJob { view, objects: &[], next: None, partner: Some(partner) };
    let planes = truth(&job, &[TruthLayer::Disparity, TruthLayer::Depth]);
    for (i, x, y) in pixels() {
        let d = FX * baseline / value(&planes, "depth", i);
        let found = [value(&planes, "disparity.X", i), value(&planes, "disparity.Y", i)];
        let expected = if level { [d, 0.0] } else { [0.0, d] };
        let error = [0, 1].map(|axis| (found[axis] - expected[axis]).abs());
        assert!(error.iter().all(|error| *error < ROUNDING_PX), "{x}, {y}: {found:?}");
        // To the right things lie farther to the left, above they lie farther down.
        let to = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - DVec2::new(towards_partner.x, -towards_partner.y) * d;
        let inside = to.cmpge(DVec2::ZERO).all() && to.cmplt(DVec2::from_array(RESOLUTION.map(f64::from))).all();
        assert_eq!(value(&planes, "disparity.visible", i) == 1.0, inside, "{x}, {y}");
    }
}

#[test]
fn nothing_is_visible_in_an_image_that_there_is_not() {
    let (scene, camera) = (wall().build(), pinhole(DAffine3::IDENTITY));
    let job = TruthJob { view: View::of(&scene, &camera, RESOLUTION), objects: &[], next: None, partner: None };
    let planes = truth(&job, &[TruthLayer::Flow, TruthLayer::Disparity]);
    assert!(planes.channels().iter().all(|channel| channel.data.iter().all(|&value| value == 0.0)));
}

/// Before a wall that stays, a tile that is elsewhere in the next image: as one of two of a mesh, alone in the world,
/// mirrored, or on its way while the image is taken, each of which is kept in another way.
#[rstest]
fn flow_follows_what_moves(
    #[values(false, true)] twice: bool,
    #[values(1.0, -1.0)] mirror: f64,
    #[values(0.0, 0.02)] on_its_way: f64,
) {
    let scene = |to: DVec3, later: f64| {
        let place = |x: f64| {
            let mirrored = DAffine3::from_scale(DVec3::new(mirror, 1.0, 1.0));
            DAffine3::from_translation(to + DVec3::X * x) * mirrored
        };
        let tile = wall().diffuse(square(Vec3::ZERO, Vec3::X, Vec3::Y, 0.2), 0.5, 0.0);
        let tile = if later == 0.0 { tile.moving(&[place(0.0)]) } else { tile.moving(&[place(-later), place(later)]) };
        let aside = DAffine3::from_translation(DVec3::new(0.0, 0.45, -1.5));
        (if twice { tile.again(aside) } else { tile }).build()
    };
    let (from, to) = (DVec3::new(-0.1, 0.0, -1.0), DVec3::new(0.05, 0.1, -1.25));
    // Still in one image, and in the middle of its way when the exposure of the other is half over.
    let [now, later] = [scene(from, 0.0), scene(to, on_its_way)];
    let still = pinhole(DAffine3::IDENTITY);
    let next = Recording {
        motion: None,
        start_s: 0.0,
        exposure_s: 0.01,
        row_time_s: 0.0,
        first_row: 0.0,
        duration_s: 0.01,
        frame_interval_s: 0.1,
    };
    let next = still.clone().recording(next);
    let layers = [TruthLayer::Flow, TruthLayer::Instance, TruthLayer::Position];
    let planes = ask_of([&now, &later], [&still, &next], &layers);
    let project = |p: DVec3| DVec2::new(p.x, -p.y) * FX / -p.z;
    let mut on_tile = 0;
    for (i, x, y) in pixels() {
        let p = vector(&planes, "position", i);
        let moved = if value(&planes, "instance", i) == 2.0 { to - from } else { DVec3::ZERO };
        on_tile += usize::from(moved != DVec3::ZERO);
        let expected = project(p + moved) - project(p);
        let flow = DVec2::new(value(&planes, "flow.X", i), value(&planes, "flow.Y", i));
        // Positions are single precision in both images.
        assert!((flow - expected).length() < 2.0 * ROUNDING_PX, "{x}, {y}: {flow}, not {expected}");
        if moved == DVec3::ZERO && p.z == -2.0 {
            // Seen from the camera, the wall at p is behind the moved tile where the way passes it.
            let pass = p * (to.z / p.z) - to;
            let margin = pass.abs().max_element() - 0.2;
            if margin.abs() > 1e-3 && !twice {
                assert_eq!(value(&planes, "flow.visible", i) == 1.0, margin > 0.0, "{x}, {y}");
            }
        }
    }
    // 0.4·80 px across at 1 m.
    assert!((31 * 31..=33 * 33).contains(&on_tile), "{on_tile}");
}

#[test]
fn what_the_next_image_hides_is_not_visible_in_it() {
    // A post between x = −0.1 and 0.1 at half the way, and a camera that moves to the right by 0.1 m.
    let post = vec![
        [Vec3::new(-0.1, -4.0, -1.0), Vec3::new(0.1, -4.0, -1.0), Vec3::new(0.1, 4.0, -1.0)],
        [Vec3::new(-0.1, -4.0, -1.0), Vec3::new(0.1, 4.0, -1.0), Vec3::new(-0.1, 4.0, -1.0)],
    ];
    let scene = wall().diffuse(post, 0.2, 0.0).build();
    let [camera, next] = [0, 1].map(|number| moving(DVec3::X, 0.0, number));
    let planes = ask(&scene, &camera, &next, &[TruthLayer::Instance, TruthLayer::Position, TruthLayer::Flow]);
    let (mut hidden, mut shown) = (0, 0);
    for (i, x, y) in pixels() {
        let visible = value(&planes, "flow.visible", i) == 1.0;
        let p = vector(&planes, "position", i);
        // The cameras stand at the middle of their exposures. Seen from there, the wall at p is behind the post where
        // the way passes z = −1 half way between −0.1 and 0.1.
        let eye = 0.1 + 1e-3;
        let passes = (p.x + eye) / 2.0;
        let pixel = DVec2::new(x as f64 + 0.5 + value(&planes, "flow.X", i), y as f64 + 0.5);
        if !(0.0..f64::from(RESOLUTION[0])).contains(&pixel.x) {
            continue;
        }
        if value(&planes, "instance", i) == 2.0 {
            assert!(visible, "{x}, {y}: the post is in front of everything");
        } else if passes.abs() < 0.1 - 1e-6 {
            hidden += 1;
            assert!(!visible, "{x}, {y}: behind the post");
        } else if passes.abs() > 0.1 + 1e-6 {
            shown += 1;
            assert!(visible, "{x}, {y}: beside the post");
        }
    }
    assert!(hidden > 0 && shown > 0, "{hidden} hidden, {shown} shown");
}

#[test]
fn instances_and_materials_have_the_numbers_of_the_description() {
    // One mesh placed three times, a wall between them in the list.
    let tile = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
    let scene = Stage::default()
        .diffuse(square(Vec3::new(0.0, 0.0, -1.0), Vec3::X, Vec3::Y, 0.1), 0.5, 0.0)
        .again(tile(-0.25))
        .diffuse(square(Vec3::new(0.0, 0.0, -2.0), Vec3::X, Vec3::Y, 0.4), 0.5, 0.0)
        .again_of(0, tile(0.25))
        .build();
    let camera = pinhole(DAffine3::IDENTITY);
    let layers = [TruthLayer::Instance, TruthLayer::Material, TruthLayer::Depth, TruthLayer::Uv];
    let planes = ask(&scene, &camera, &camera, &layers);
    for (i, x, y) in pixels() {
        let at = direction(x, y);
        let on_tile = |centre: f64| (at.x - centre).abs() < 0.1 && at.y.abs() < 0.1;
        let (instance, material, depth) = match () {
            () if on_tile(0.0) => (1.0, 1.0, 1.0),
            () if on_tile(-0.25) => (2.0, 1.0, 1.0),
            () if on_tile(0.25) => (4.0, 1.0, 1.0),
            () if at.x.abs() < 0.2 && at.y.abs() < 0.2 => (3.0, 2.0, 2.0),
            () => (0.0, 0.0, f64::INFINITY),
        };
        let found = ["instance", "material", "depth"].map(|name| value(&planes, name, i));
        let rounding = if depth.is_finite() { 1e-6 } else { 0.0 };
        assert_eq!(found[..2], [instance, material], "{x}, {y}");
        assert!(found[2] == depth || (found[2] - depth).abs() < rounding, "{x}, {y}: {}", found[2]);
        assert_eq!(value(&planes, "uv.U", i).is_nan(), instance == 0.0, "{x}, {y}");
    }
}

/// Linear sRGB of a reflectance under D65, by the sums over whole nanometres that CIE 15 asks for.
fn linear_srgb(reflectance: &Spectrum) -> DVec3 {
    let d65 = illuminant::d65();
    let white = DVec3::from_array(cie::xyz(d65));
    let xyz = DVec3::from_array(cie::xyz(&reflectance.product(d65)));
    ColourSpace::Srgb.to_xyz().inverse() * (ColourSpace::Srgb.white() / white * xyz)
}

#[rstest]
#[case::white(Spectrum::constant(1.0))]
#[case::grey(Spectrum::constant(0.18))]
#[case::slope(Spectrum::from_fn(|nm| (nm - 300.0) / 800.0))]
#[case::band(Spectrum::from_fn(|nm| (-((nm - 550.0) / 40.0).powi(2)).exp()))]
fn albedo_is_the_colour_of_the_reflectance(#[case] reflectance: Spectrum) {
    let expected = linear_srgb(&reflectance);
    let model = MaterialModel::Diffuse(Diffuse { reflectance: TexturedColour::plain(Colour::Spectrum(reflectance)) });
    let scene = Stage::default().mesh(square(Vec3::new(0.0, 0.0, -2.0), Vec3::X, Vec3::Y, 4.0), model, None).build();
    let camera = pinhole(DAffine3::IDENTITY);
    let planes = ask(&scene, &camera, &camera, &[TruthLayer::Albedo]);
    for (i, x, y) in pixels() {
        let found = DVec3::from_array(["albedo.R", "albedo.G", "albedo.B"].map(|name| value(&planes, name, i)));
        // D65 is given at steps of 5 nm and bends by some 5 % from one to the next: a sum over steps of 6.25 nm differs
        // from one over single nanometres by a tenth of that, and by less where it is summed over the whole of the
        // observer.
        assert!((found - expected).abs().max_element() < 2e-3, "{x}, {y}: {found}, not {expected}");
    }
}
