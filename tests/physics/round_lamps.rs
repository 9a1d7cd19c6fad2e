//! Spheres, disks and cylinders that emit: the irradiance of closed forms, and the light of meshes of the same shape.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DAffine3, DQuat, DVec3, Vec3};
use photosite::geometry::QuadricKind;
use photosite::integrator::RenderSettings;
use photosite::light::{Facing, LightSampleContext};
use photosite::math::statistics::Moments;
use photosite::scene::Scene;
use photosite::spectrum::Wavelengths;
use rstest::rstest;

use crate::bsdf_cases::Uniform;
use crate::light_paths::{compare, glass, gold, image, lens};
use crate::stage::{Stage, sphere, square};

const RADIANCE: f32 = 2.0;

/// A quadric about a place, its axis from +Z to a direction, alone.
fn lamp(kind: QuadricKind, size: DVec3, axis: DVec3, place: DVec3) -> DAffine3 {
    let turn = DQuat::from_rotation_arc(DVec3::Z, axis.normalize());
    let start = if kind == QuadricKind::Cylinder { place - turn * DVec3::Z * (size.z / 2.0) } else { place };
    DAffine3::from_scale_rotation_translation(size, turn, start)
}

/// The irradiance at a point that faces +Y, by light sampling.
fn irradiance(scene: &Scene, point: Vec3) -> Moments {
    let ctx = LightSampleContext { point, facing: Facing::Front(Vec3::Y) };
    let wavelengths = Wavelengths::new([450.0, 500.0, 550.0, 600.0], [1.0; 4]);
    let (mut uniform, mut found) = (Uniform::new(5), Moments::default());
    for _ in 0..1 << 18 {
        let (_, u) = uniform.lobe_and_direction();
        let sample = scene.sample_light(&ctx, 0.0, u, &wavelengths);
        found.add(sample.map_or(0.0, |s| f64::from(s.radiance[0] * s.wi.y.max(0.0) / s.pdf.0)));
    }
    found
}

/// Within five standard errors (chance of 6e-7), and the roundings of single precision, 1e-5 for points near a lamp.
fn assert_irradiance(found: &Moments, expected: f64) {
    let error = found.variance_of_mean().sqrt();
    assert!(
        (found.mean() - expected).abs() <= 5.0 * error + 1e-5 * expected,
        "{} ± {error}, not {expected}",
        found.mean()
    );
}

#[rstest]
#[case::near(1.0, DVec3::new(0.0, 1.01, 0.0))]
#[case::aside(0.5, DVec3::new(1.2, 0.9, -0.7))]
#[case::far(0.01, DVec3::new(300.0, 400.0, 0.0))]
#[case::tiny(1e-6, DVec3::new(0.0, 30.0, 40.0))]
#[case::as_large_as_the_sun(6.96e8, DVec3::new(0.0, 1.496e11, 0.0))]
fn a_sphere_above_the_horizon_gives_what_its_disk_gives(#[case] radius: f64, #[case] place: DVec3) {
    let to_world = lamp(QuadricKind::Sphere, DVec3::splat(radius), DVec3::Z, place);
    let scene = Stage::default().quadric(QuadricKind::Sphere, to_world, 0.0, (RADIANCE, false)).build();
    let expected = f64::from(RADIANCE) * PI * (radius / place.length()).powi(2) * place.y / place.length();
    assert_irradiance(&irradiance(&scene, Vec3::ZERO), expected);
}

#[rstest]
#[case::near(1.0, 0.2)]
#[case::as_far_as_wide(1.0, 1.0)]
#[case::far(0.02, 30.0)]
fn a_disk_above_its_axis_gives_the_closed_form(#[case] radius: f64, #[case] height: f64) {
    let to_world = lamp(QuadricKind::Disk, DVec3::splat(radius), DVec3::NEG_Y, DVec3::Y * height);
    let scene = Stage::default().quadric(QuadricKind::Disk, to_world, 0.0, (RADIANCE, false)).build();
    let expected = f64::from(RADIANCE) * PI * radius.powi(2) / (radius.powi(2) + height.powi(2));
    assert_irradiance(&irradiance(&scene, Vec3::ZERO), expected);
}

/// Irradiance at the origin from the front or the back of a cylinder, by the midpoint rule over its surface.
fn of_cylinder(to_world: &DAffine3, side: f64) -> f64 {
    let (around, along) = (2000, 2000);
    let [x, z] = [to_world.matrix3.x_axis.length(), to_world.matrix3.z_axis.length()];
    let area = TAU * x * z / f64::from(around * along);
    let mut sum = 0.0;
    for i in 0..around {
        let (sin, cos) = (TAU * (f64::from(i) + 0.5) / f64::from(around)).sin_cos();
        let normal = to_world.transform_vector3(DVec3::new(cos, sin, 0.0)).normalize();
        for j in 0..along {
            let point = to_world.transform_point3(DVec3::new(cos, sin, (f64::from(j) + 0.5) / f64::from(along)));
            let wi = point.normalize();
            let cos_at_lamp = -side * normal.dot(wi);
            sum += wi.y.max(0.0) * cos_at_lamp.max(0.0) / point.length_squared() * area;
        }
    }
    f64::from(RADIANCE) * sum
}

#[rstest]
#[case::above(DVec3::new(0.1, 0.1, 2.0), DVec3::X, DVec3::Y * 0.5)]
#[case::beside(DVec3::new(0.3, 0.3, 1.0), DVec3::new(0.3, 1.0, 0.2), DVec3::new(0.9, 0.3, 0.2))]
#[case::end_on(DVec3::new(0.4, 0.4, 1.0), DVec3::Y, DVec3::new(0.7, 1.5, 0.0))]
#[case::far(DVec3::new(0.01, 0.01, 0.5), DVec3::X, DVec3::new(30.0, 40.0, 0.0))]
fn a_cylinder_gives_the_integral_over_its_front(#[case] size: DVec3, #[case] axis: DVec3, #[case] place: DVec3) {
    let to_world = lamp(QuadricKind::Cylinder, size, axis, place);
    let scene = Stage::default().quadric(QuadricKind::Cylinder, to_world, 0.0, (RADIANCE, false)).build();
    // The midpoint rule leaves out 1e-5 at the edge of what faces the point, where the cosine has a kink.
    assert_irradiance(&irradiance(&scene, Vec3::ZERO), of_cylinder(&to_world, 1.0));
}

#[test]
fn a_long_cylinder_gives_what_one_without_end_gives() {
    // The section is what counts of a lamp without end: a circle that is seen under sin α = R/d, E = πL·R/d.
    let to_world = lamp(QuadricKind::Cylinder, DVec3::new(0.3, 0.3, 200.0), DVec3::X, DVec3::Y);
    let scene = Stage::default().quadric(QuadricKind::Cylinder, to_world, 0.0, (RADIANCE, false)).build();
    let found = irradiance(&scene, Vec3::ZERO);
    // What lies beyond 100 m has cos² ≈ 1e-4 on either side: 2/3·1e-6 of the whole, below the noise.
    assert_irradiance(&found, PI * f64::from(RADIANCE) * 0.3);
}

#[test]
fn within_a_cylinder_its_back_shines() {
    let to_world = lamp(QuadricKind::Cylinder, DVec3::new(0.5, 0.5, 2.0), DVec3::Z, DVec3::new(0.2, 0.1, 0.4));
    for two_sided in [true, false] {
        let scene = Stage::default().quadric(QuadricKind::Cylinder, to_world, 0.0, (RADIANCE, two_sided)).build();
        let expected = if two_sided { of_cylinder(&to_world, -1.0) } else { 0.0 };
        assert_irradiance(&irradiance(&scene, Vec3::ZERO), expected);
    }
}

/// A floor, a block of metal and one of glass under a lamp, which adds itself.
fn room(lamp: impl FnOnce(Stage) -> Stage) -> Scene {
    let ball = |at: Vec3| sphere(8, 0.3).into_iter().map(move |triangle| triangle.map(|corner| corner + at)).collect();
    let stage = Stage::default()
        .diffuse(square(Vec3::new(0.0, -0.5, 0.0), Vec3::Z, Vec3::X, 2.0), 0.7, 0.0)
        .mesh(ball(Vec3::new(-0.5, -0.1, 0.3)), gold(0.2), None)
        .mesh(ball(Vec3::new(0.6, -0.1, 0.2)), glass(0.0), None);
    lamp(stage).build()
}

/// A quadric as triangles with as many corners around, none off it.
fn tessellated(kind: QuadricKind, to_world: &DAffine3, around: u32) -> Vec<[Vec3; 3]> {
    let corner = |i: u32, end: f64| {
        let (sin, cos) = (TAU * f64::from(i % around) / f64::from(around)).sin_cos();
        DVec3::new(cos, sin, end)
    };
    let unit: Vec<[DVec3; 3]> = match kind {
        QuadricKind::Sphere => sphere(around / 2, 1.0).into_iter().map(|t| t.map(|corner| corner.as_dvec3())).collect(),
        QuadricKind::Disk => (0..around).map(|i| [DVec3::ZERO, corner(i, 0.0), corner(i + 1, 0.0)]).collect(),
        QuadricKind::Cylinder => (0..around)
            .flat_map(|i| {
                let [a, b, c, d] = [corner(i, 0.0), corner(i + 1, 0.0), corner(i + 1, 1.0), corner(i, 1.0)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
    };
    unit.into_iter().map(|triangle| triangle.map(|corner| to_world.transform_point3(corner).as_vec3())).collect()
}

#[rstest]
#[case::sphere(QuadricKind::Sphere, lamp(QuadricKind::Sphere, DVec3::splat(0.3), DVec3::Z, DVec3::new(-0.1, 0.8, 0.2)))]
#[case::disk(QuadricKind::Disk, lamp(QuadricKind::Disk, DVec3::splat(0.4), DVec3::NEG_Y, DVec3::new(0.1, 0.9, 0.1)))]
#[case::cylinder(
    QuadricKind::Cylinder,
    lamp(QuadricKind::Cylinder, DVec3::new(0.1, 0.1, 1.2), DVec3::new(1.0, 0.2, 0.4), DVec3::new(0.0, 0.7, 0.1))
)]
fn round_lamps_shine_as_meshes_of_their_shape_and_with_paths_from_lamps(
    #[case] kind: QuadricKind,
    #[case] to_world: DAffine3,
) {
    let exact = room(|stage| stage.quadric(kind, to_world, 0.4, (RADIANCE, false)));
    let mesh = room(|stage| stage.diffuse(tessellated(kind, &to_world, 256), 0.4, RADIANCE));
    let total = |scene: &Scene, seed: u64| {
        let estimate = image(scene, &lens(), RenderSettings { seed, ..RenderSettings::default() }, |_| {});
        let sum = |planes: &photosite::image::Planes| -> f64 {
            planes.channels().iter().flat_map(|channel| &channel.data).map(|&v| f64::from(v)).sum()
        };
        (sum(&estimate.mean), sum(&estimate.variance))
    };
    let ((found, variance), (expected, other)) = (total(&exact, 1), total(&mesh, 2));
    // Four standard errors, √2 as large where both bands come from the same paths, and the part of the outline that lies
    // beyond the chords: (2π/256)²/6 = 1e-4.
    let error = (2.0 * (variance + other)).sqrt();
    assert!((found - expected).abs() < 4.0 * error + 1e-4 * expected, "{found}, not {expected} ± {error}");
    assert!(error < 0.01 * expected, "{error} of {expected} tells nothing");
    // Caustics of the glass.
    let gain =
        compare(&format!("{kind:?}"), &exact, &lens(), RenderSettings { light_paths: Some(1.0), ..Default::default() });
    assert!(gain > 1.0, "{gain}");
}

#[test]
fn the_inside_of_a_sphere_is_a_furnace() {
    // A white ball in uniform light is as bright as that, whether it comes from an environment or from around.
    let ball = || Stage::default().diffuse(sphere(12, 0.5), 1.0, 0.0);
    let around =
        DAffine3::from_scale_rotation_translation(DVec3::splat(5.0), DQuat::IDENTITY, DVec3::new(0.5, 0.0, 0.0));
    let scene = ball().quadric(QuadricKind::Sphere, around, 0.0, (RADIANCE, true)).build();
    let settings = || RenderSettings::default();
    let [found, expected] = [scene, ball().environment(RADIANCE).build()]
        .map(|scene| image(&scene, &lens(), settings(), |_| {}))
        .map(|estimate| estimate.mean.channels()[0].data.clone());
    let scale = f64::from(expected[0]);
    for (found, expected) in found.iter().zip(&expected) {
        // The ball is convex, so that each path meets the lamp once: what is left are the wavelengths.
        assert!((f64::from(found - expected)).abs() < 0.02 * scale, "{found} {expected}");
    }
}

#[test]
fn what_shines_lights_itself_from_inside_only() {
    // A closed room whose wall shines and reflects half: L/(1 − ½), to what 24 bounces leave.
    let around = DAffine3::from_rotation_translation(DQuat::from_rotation_x(FRAC_PI_2), DVec3::new(0.2, 0.1, 0.3))
        * DAffine3::from_scale(DVec3::splat(4.0));
    let scene =
        |reflectance: f32| Stage::default().quadric(QuadricKind::Sphere, around, reflectance, (RADIANCE, true)).build();
    let mean = |scene: &Scene| {
        let estimate = image(scene, &lens(), RenderSettings { splitting: None, ..RenderSettings::default() }, |_| {});
        estimate.mean.channels()[0].data.iter().map(|&v| f64::from(v)).sum::<f64>()
    };
    // image() ends paths after six segments: 1 + ½ + … + ½⁵.
    let ratio = mean(&scene(0.5)) / mean(&scene(0.0));
    let expected = (1.0 - 0.5f64.powi(6)) / 0.5;
    assert!((ratio / expected - 1.0).abs() < 0.005, "{ratio}, not {expected}");
}
