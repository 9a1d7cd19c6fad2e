//! Lights without a surface that do more than shine alike in all directions: projectors, measured profiles, laser
//! beams, lights that move.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use photosite::light::{GaussianBeam, LightSampleContext, PointLight, Profile, Projector};
use photosite::scene::Scene;
use photosite::scene::description::{Colour, EmissionDescription, LightDescription, LightKind};
use photosite::spectrum::{Spectrum, Wavelengths};
use photosite::texture::{Bitmap, Texels};
use rstest::rstest;

use crate::stage::Stage;

const SLIDE: [usize; 2] = [16, 12];
/// Pinhole matrix of the projector, in pixels of the slide.
const FOCAL_PX: [f64; 2] = [14.0, 15.0];
const PRINCIPAL_PX: [f64; 2] = [7.0, 9.0];

fn lamp(kind: LightKind, to_world: DAffine3, later: Vec<DAffine3>) -> Scene {
    // 1 W/nm, W/nm/sr or W/nm/m² at every wavelength.
    let emission =
        EmissionDescription { colour: Colour::Spectrum(Spectrum::constant(1.0)), level: None, texture: None };
    Stage::default().light(LightDescription { name: String::new(), to_world, later, kind, emission }).build()
}

/// Irradiance on a surface at a point, W·m⁻²·nm⁻¹, from one sample.
fn irradiance(scene: &Scene, point: Vec3, normal: Vec3, time: f32, u: [f32; 2]) -> f64 {
    let wavelengths = Wavelengths::new([550.0; 4], [1.0; 4]);
    let sample = scene.sample_light(&LightSampleContext::anywhere(point), time, u, &wavelengths);
    sample.map_or(0.0, |s| f64::from(s.radiance[0] * s.wi.dot(normal).max(0.0) / s.pdf.0))
}

fn projector(white: impl Fn(usize) -> bool, radius_m: f64, focus_distance_m: f64) -> LightKind {
    let [width, height] = SLIDE;
    let texels = (0..width * height).map(|i| if white(i) { [255; 4] } else { [0, 0, 0, 255] }).collect();
    let slide = Bitmap { name: "slide".into(), width, height, texels: Texels::Rgba8(texels) };
    let [w, h] = [width as f64, height as f64];
    let extent = [w / FOCAL_PX[0], h / FOCAL_PX[1]];
    let shift = [(w / 2.0 - PRINCIPAL_PX[0]) / FOCAL_PX[0], (PRINCIPAL_PX[1] - h / 2.0) / FOCAL_PX[1]];
    LightKind::Projector(Projector::new(Arc::new(slide), extent, shift, radius_m, focus_distance_m))
}

/// Where OpenCV's pinhole camera has a position of the slide, at a depth: x right, y down, z forward.
fn place(to_world: &DAffine3, [u, v]: [f64; 2], depth: f64) -> Vec3 {
    let (x, y) = ((u - PRINCIPAL_PX[0]) / FOCAL_PX[0], (v - PRINCIPAL_PX[1]) / FOCAL_PX[1]);
    to_world.transform_point3(DVec3::new(x, -y, -1.0) * depth).as_vec3()
}

#[test]
fn a_pixel_of_the_slide_lands_where_a_camera_would_see_it() {
    let to_world = DAffine3::from_rotation_translation(glam::DQuat::from_rotation_y(0.7), DVec3::new(1.0, 2.0, -3.0));
    let towards = to_world.matrix3.z_axis.as_vec3();
    for pixel in [0, 5 * 16 + 11, 11 * 16 + 15] {
        let scene = lamp(projector(|i| i == pixel, 0.0, 1.0), to_world, Vec::new());
        let [column, row] = [(pixel % 16) as f64, (pixel / 16) as f64];
        for depth in [0.4, 3.0] {
            for (du, dv, inside) in
                [(0.02, 0.02, true), (0.98, 0.98, true), (-0.02, 0.5, false), (1.02, 0.5, false), (0.5, 1.02, false)]
            {
                let point = place(&to_world, [column + du, row + dv], depth);
                let light = irradiance(&scene, point, towards, 0.0, [0.5; 2]);
                assert_eq!(light > 0.0, inside, "{pixel} {depth} {du} {dv}");
            }
        }
    }
}

#[rstest]
#[case::sharp(0.0, 1.0)]
#[case::focused(0.05, 2.0)]
#[case::out_of_focus(0.05, 0.7)]
fn the_whole_flux_arrives(#[case] radius_m: f64, #[case] focus_distance_m: f64) {
    let scene = lamp(projector(|_| true, radius_m, focus_distance_m), DAffine3::IDENTITY, Vec::new());
    // A wall 2 m away, larger than the image of 2.3 m by 1.6 m and its blur.
    let (cells, half) = (600u16, 2.0f32);
    let side = 2.0 * half / f32::from(cells);
    let mut flux = 0.0;
    for i in 0..u32::from(cells) * u32::from(cells) {
        let [x, y] = [i % u32::from(cells), i / u32::from(cells)].map(|i| (i as f32 + 0.5) * side - half);
        // Points of the opening by a lattice.
        let u = [(i as f32 * 0.754_877_7).fract(), (i as f32 * 0.569_840_3).fract()];
        flux += irradiance(&scene, Vec3::new(x, y, -2.0), Vec3::Z, 0.0, u) * f64::from(side * side);
    }
    // Cells at the border of the image, 1 in 150 of its width, are in or out: about 1/(150·√(2·350)) if by chance, at
    // most half a cell of 350 and one of 240 where the border runs along them.
    assert!((flux - 1.0).abs() < 0.5 / 350.0 + 0.5 / 240.0, "{flux}");
}

#[test]
fn what_is_in_focus_is_sharp_and_what_is_not_is_blurred_by_the_opening() {
    // The edge of the slide's left half. At the distance d of a wall and f of the focus the opening of radius r spreads
    // it by ±r·|1 − d/f|.
    let scene = lamp(projector(|i| i % 16 < 8, 0.05, 1.0), DAffine3::IDENTITY, Vec::new());
    let edge = |depth: f64| place(&DAffine3::IDENTITY, [8.0, 9.0], depth);
    const CELLS: u16 = 64;
    let lit = |depth: f64, aside: f32| {
        let at = |i: u16| (f32::from(i) + 0.5) / f32::from(CELLS);
        let us = (0..CELLS * CELLS).map(|i| [at(i % CELLS), at(i / CELLS)]);
        let lit = us.filter(|&u| irradiance(&scene, edge(depth) + Vec3::X * aside, Vec3::Z, 0.0, u) > 0.0).count();
        lit as f64 / f64::from(CELLS * CELLS)
    };
    assert_eq!([lit(1.0, -0.001), lit(1.0, 0.001)], [1.0, 0.0]);
    assert_eq!([lit(2.0, -0.051), lit(2.0, 0.051)], [1.0, 0.0]);
    for aside in [-0.04f32, -0.02, 0.0, 0.01, 0.03, 0.04] {
        // From a wall twice as far as the focus an opening's points on one side of x = −aside see the lit half: the
        // segment of a disk, (arccos t − t·√(1 − t²))/π with t = x/r.
        let t = f64::from(aside) / 0.05;
        let expected = (t.acos() - t * (1.0 - t * t).sqrt()) / PI;
        // Cells have equal areas of the opening, and a chord cuts at most two in each of their rows: half of them
        // wrong.
        let found = lit(2.0, aside);
        assert!((found - expected).abs() < 1.0 / f64::from(CELLS), "{aside}: {found} is not {expected}");
    }
}

#[test]
fn a_profile_shines_by_its_candela_over_the_square_of_the_distance() {
    let degrees = [0.0f32, 90.0].map(f32::to_radians).to_vec();
    let profile = Profile::new(degrees, vec![0.0], vec![8.0, 2.0]);
    // Shining down.
    let down = DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let scene = lamp(LightKind::Profile(profile), down, Vec::new());
    for (point, candela) in [(Vec3::NEG_Y * 2.0, 8.0), (Vec3::new(1.5, -1.5, 0.0), 5.0), (Vec3::X, 2.0)] {
        let normal = -point.normalize();
        let expected = candela / f64::from(point.length_squared());
        let found = irradiance(&scene, point, normal, 0.0, [0.5; 2]);
        assert!((found / expected - 1.0).abs() < 1e-4, "{point}: {found} {expected}");
    }
    assert_eq!(irradiance(&scene, Vec3::Y, Vec3::NEG_Y, 0.0, [0.5; 2]), 0.0);
}

/// A beam that is turned and aside, so that no axis of the world is one of its own.
fn beam(waist_radius_m: [f64; 2], divergence_deg: [f64; 2]) -> (Scene, DAffine3) {
    let to_world = DAffine3::from_rotation_translation(
        glam::DQuat::from_euler(glam::EulerRot::YXZ, 0.7, -0.3, 0.5),
        DVec3::new(0.2, -0.4, 1.0),
    );
    let beam = GaussianBeam::new(waist_radius_m, divergence_deg.map(f64::to_radians));
    (lamp(LightKind::GaussianBeam(beam), to_world, Vec::new()), to_world)
}

#[rstest]
#[case::collimated([2e-3, 1e-3], [0.0, 0.0], 1.0)]
#[case::diverging([1e-3, 1e-3], [2.0, 2.0], 0.5)]
#[case::diverging_from_a_point([0.0, 0.0], [5.0, 3.0], 2.0)]
#[case::line([0.5e-3, 1e-3], [0.0, 30.0], 1.0)]
fn a_gaussian_beam_has_its_flux_and_its_width_on_any_plane_across_it(
    #[case] waist_m: [f64; 2],
    #[case] divergence_deg: [f64; 2],
    #[case] z: f64,
) {
    let (scene, to_world) = beam(waist_m, divergence_deg);
    let radius = |i: usize| waist_m[i].hypot(z * divergence_deg[i].to_radians().tan());
    let along = to_world.matrix3.z_axis.as_vec3();
    let at = |x: f64, y: f64| to_world.transform_point3(DVec3::new(x, y, -z)).as_vec3();
    // Sums of a Gaussian function over a lattice of a fifth of its radius differ from its integral by exp(−π²·5²/2)
    // only; the beam ends at three radii, beyond which there is 1.5e-8 of the flux.
    let cells = -16..=16;
    let step = [0, 1].map(|i| radius(i) * 0.2);
    let (mut flux, mut variance) = (0.0, [0.0; 2]);
    for row in cells.clone() {
        for column in cells.clone() {
            let [x, y] = [f64::from(column) * step[0], f64::from(row) * step[1]];
            let part = irradiance(&scene, at(x, y), along, 0.0, [0.5; 2]) * step[0] * step[1];
            flux += part;
            variance = [variance[0] + part * x * x, variance[1] + part * y * y];
        }
    }
    // The scene and its points are in 32 bits: a point 1 m away is placed to 6e-8 m, of radii of 0.5 mm 1.2e-4, which
    // moves the beam as a whole and its slope where the exponent is steepest (6 per radius) by 7e-4 of the part there.
    assert!((flux - 1.0).abs() < 1e-3, "{flux}");
    for i in [0, 1] {
        // ISO 11146-1 §3: the radius is twice the standard deviation.
        let found = 2.0 * (variance[i] / flux).sqrt();
        assert!((found / radius(i) - 1.0).abs() < 1e-3, "{i}: {found} {}", radius(i));
    }
}

/// A beam among lamps of together the intensity that the tree takes it for: 1 W in a cone of 0.5 rad is 1.3 W/sr. Where it
/// does not shine, a lamp is found about half of the times. With the intensity of its true cone the beam all but hid the
/// lamps that share a branch of the tree with it: of their light 6 % was found.
#[test]
fn a_beam_does_not_hide_the_lamps_beside_it() {
    let emission = |level: f64| EmissionDescription {
        colour: Colour::Spectrum(Spectrum::constant(level as f32)),
        level: None,
        texture: None,
    };
    let light = |kind: LightKind, position: DVec3, level: f64| LightDescription {
        name: String::new(),
        to_world: DAffine3::from_translation(position),
        later: Vec::new(),
        kind,
        emission: emission(level),
    };
    let beam = GaussianBeam::new([1e-3; 2], [0.0; 2]);
    let mut stage = Stage::default().light(light(LightKind::GaussianBeam(beam), DVec3::Z, 1.0));
    let mut expected = 0.0;
    // Below the lamps, 0.3 m beside the beam's axis.
    let point = Vec3::new(0.3, 0.0, -1.0);
    for i in 0..20 {
        let angle = f64::from(i) * 2.4;
        let position = DVec3::new(0.5 * angle.cos(), 0.5 * angle.sin(), 1.0 + 0.01 * f64::from(i));
        let to_lamp = position - point.as_dvec3();
        expected += 1.3 / 20.0 * to_lamp.z / to_lamp.length().powi(3);
        stage = stage.light(light(LightKind::Point(PointLight), position, 1.3 / 20.0));
    }
    let scene = stage.build();
    const SAMPLES: usize = 4096;
    let draws: Vec<f64> = (0..SAMPLES)
        .map(|i| irradiance(&scene, point, Vec3::Z, 0.0, [(i as f32 + 0.5) / SAMPLES as f32, 0.5]))
        .collect();
    let found = draws.iter().filter(|&&draw| draw > 0.0).count() as f64 / SAMPLES as f64;
    assert!(found > 0.25, "{found}");
    // Numbers are evenly spread: each lamp's share of them is right to one in its count, of 20 lamps.
    let mean = draws.iter().sum::<f64>() / SAMPLES as f64;
    assert!((mean / expected - 1.0).abs() < 40.0 / (found * SAMPLES as f64), "{mean} {expected}");
}

#[test]
fn light_of_a_gaussian_beam_travels_on_straight_lines() {
    // A ray of the beam, by the wavefront's slope at a point far off the axis: all points of it see the light come from
    // the same direction where the beam began as a point, and in the same direction where it is collimated.
    for (waist_m, divergence_deg, origin) in [([0.0; 2], [10.0; 2], Some(DVec3::ZERO)), ([3e-3; 2], [0.0; 2], None)] {
        let (scene, to_world) = beam(waist_m, divergence_deg);
        let wavelengths = Wavelengths::new([550.0; 4], [1.0; 4]);
        for z in [0.2, 1.0, 5.0] {
            let radius = waist_m[0].hypot(z * f64::tan(divergence_deg[0].to_radians()));
            let local = DVec3::new(0.7 * radius, -0.4 * radius, -z);
            let point = to_world.transform_point3(local).as_vec3();
            let ctx = LightSampleContext::anywhere(point);
            let sample = scene.sample_light(&ctx, 0.0, [0.5; 2], &wavelengths).expect("light");
            let expected = to_world.transform_vector3(origin.map_or(DVec3::Z, |origin| (origin - local).normalize()));
            assert!(sample.wi.distance(expected.as_vec3()) < 1e-5, "{z}: {} {expected}", sample.wi);
        }
    }
    // Nothing goes backwards.
    let (scene, to_world) = beam([1e-3; 2], [0.0; 2]);
    let behind = to_world.transform_point3(DVec3::Z * 0.1).as_vec3();
    assert_eq!(irradiance(&scene, behind, to_world.matrix3.z_axis.as_vec3(), 0.0, [0.5; 2]), 0.0);
}

#[test]
fn a_lamp_that_moves_is_where_its_time_has_it() {
    let places = [0.0, 2.0].map(|x| DAffine3::from_translation(DVec3::new(x, 1.0, 0.0)));
    let scene = lamp(LightKind::Point(PointLight), places[0], vec![places[1]]);
    for (time, x) in [(0.0, 0.0f32), (0.25, 0.5), (1.0, 2.0)] {
        let found = irradiance(&scene, Vec3::ZERO, Vec3::Y, time, [0.5; 2]);
        let distance = x.hypot(1.0);
        assert!((found * f64::from(distance.powi(3)) - 1.0).abs() < 1e-5, "{time}: {found}");
    }
}
