//! Light transport in scenes whose answer is known.

use std::f64::consts::PI;

use glam::{DAffine3, DVec3, Vec3};
use photosite::geometry::Ray;
use photosite::integrator::{PathLimits, radiance};
use photosite::light::{DirectionalLight, PointLight, SpotLight};
use photosite::math::statistics::Moments;
use photosite::sampler::{Sampler, SamplerKind};
use photosite::scene::Scene;
use photosite::scene::description::{
    AlphaMode, Colour, Dielectric, EmissionDescription, LayeredDescription, LightDescription, LightKind, MaterialModel,
    Roughness, TexturedFactor,
};
use photosite::spectrum::{Dispersion, Spectrum, Wavelengths, illuminant, library};
use rstest::rstest;

use crate::stage::{Stage, sphere, square};

/// Moments of the radiance along a ray at one wavelength.
pub(crate) fn along(scene: &Scene, origin: Vec3, direction: Vec3, max_depth: u32, paths: u32) -> Moments {
    along_within(scene, origin, direction, PathLimits { max_depth, roulette_depth: 5, splitting: 1 }, paths)
}

fn along_within(scene: &Scene, origin: Vec3, direction: Vec3, limits: PathLimits, paths: u32) -> Moments {
    let mut sampler = Sampler::new(SamplerKind::Independent, 11);
    (0..paths)
        .map(|index| {
            sampler.start(0, index);
            let mut wavelengths = Wavelengths::new([500.0; 4], [1.0; 4]);
            let ray = Ray::new(origin, direction.normalize());
            f64::from(radiance(scene, ray, &mut wavelengths, &mut sampler, limits)[0])
        })
        .collect()
}

/// Asserts that a mean is the expected one within 4.5 standard errors (one in 10⁵ by chance) and 1e-5 of rounding.
pub(crate) fn assert_mean(what: &str, got: &Moments, expected: f64) {
    let tolerance = 4.5 * got.variance_of_mean().sqrt() + 1e-5 * expected.abs();
    assert!((got.mean() - expected).abs() <= tolerance, "{what}: {} ± {tolerance}, not {expected}", got.mean());
}

fn lamp(kind: LightKind, position: DVec3, level: f32) -> LightDescription {
    LightDescription {
        name: "lamp".into(),
        // Shines along −Y: a quarter turn about X takes −Z there.
        to_world: DAffine3::from_rotation_translation(
            glam::DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
            position,
        ),
        later: Vec::new(),
        kind,
        emission: EmissionDescription {
            colour: Colour::Spectrum(Spectrum::constant(level)),
            level: None,
            texture: None,
        },
    }
}

/// A white floor at y = 0 seen from above at a slant.
fn floor_seen_from_above(stage: Stage) -> Moments {
    let floor = square(Vec3::ZERO, Vec3::X, Vec3::NEG_Z, 100.0);
    let scene = stage.diffuse(floor, 0.6, 0.0).build();
    along(&scene, Vec3::new(0.0, 1.0, 1.0), Vec3::new(0.0, -1.0, -1.0), 2, 20_000)
}

#[test]
fn illuminance_falls_with_the_square_of_the_distance() {
    for height in [0.5, 1.0, 2.0, 8.0] {
        let got =
            floor_seen_from_above(Stage::default().light(lamp(LightKind::Point(PointLight), DVec3::Y * height, 3.0)));
        assert_mean(&format!("point light at {height} m"), &got, 0.6 / std::f64::consts::PI * 3.0 / (height * height));
    }
}

#[test]
fn spot_and_directional_lights_shine_where_they_point() {
    let spot = |outer_rad: f32| LightKind::Spot(SpotLight::new(outer_rad * 0.5, outer_rad));
    let lit = floor_seen_from_above(Stage::default().light(lamp(spot(0.3), DVec3::Y * 2.0, 3.0)));
    assert_mean("spot", &lit, 0.6 / std::f64::consts::PI * 3.0 / 4.0);
    // Between the two angles, from (1, 2, 0): tan θ = 1/2, and the square of a ramp in cos θ (KHR_lights_punctual).
    let (outer, cos) = (0.7f64, 2.0 / 5f64.sqrt());
    let ramp = (cos - outer.cos()) / ((0.5 * outer).cos() - outer.cos());
    let rim = floor_seen_from_above(Stage::default().light(lamp(spot(0.7), DVec3::new(1.0, 2.0, 0.0), 3.0)));
    assert_mean("rim of the spot", &rim, 0.6 / std::f64::consts::PI * 3.0 / 5.0 * cos * ramp * ramp);
    // At 45° from a lamp over (2, 2, 0) the cone of 0.3 rad does not reach.
    let dark = floor_seen_from_above(Stage::default().light(lamp(spot(0.3), DVec3::new(2.0, 2.0, 0.0), 3.0)));
    assert_mean("beside the spot", &dark, 0.0);
    let sun =
        floor_seen_from_above(Stage::default().light(lamp(LightKind::Directional(DirectionalLight), DVec3::ZERO, 5.0)));
    assert_mean("directional", &sun, 0.6 / std::f64::consts::PI * 5.0);
}

#[test]
fn a_square_lamp_gives_the_irradiance_of_its_form_factor() {
    // Square of half-side a at height h above the point: E = 4L·(a/√(a²+h²))·atan(a/√(a²+h²)), the form factor of a
    // rectangle parallel to a differential element under its corner, four times (J. R. Howell, catalogue, B-3).
    for (half, height) in [(0.5f32, 1.0f32), (2.0, 1.0), (0.05, 0.5)] {
        let lamp = square(Vec3::Y * height, Vec3::X, Vec3::Z, half);
        let got = floor_seen_from_above(Stage::default().diffuse(lamp, 0.0, 2.0));
        let (a, h) = (f64::from(half), f64::from(height));
        let x = a / (a * a + h * h).sqrt();
        assert_mean(
            &format!("lamp {half} m at {height} m"),
            &got,
            0.6 / std::f64::consts::PI * 2.0 * 4.0 * x * x.atan(),
        );
    }
}

#[test]
fn a_lamp_with_holes_gives_less_light() {
    // The form factor of above; light is looked for and found by chance, and neither may see it where it is not.
    for (mode, alpha, part) in [
        (AlphaMode::Blend, 0.3, 0.3),
        (AlphaMode::Mask { cutoff: 0.5 }, 0.3, 0.0),
        (AlphaMode::Mask { cutoff: 0.5 }, 0.5, 1.0),
        (AlphaMode::Opaque, 0.3, 1.0),
    ] {
        let lamp = square(Vec3::Y, Vec3::X, Vec3::Z, 2.0);
        let got = floor_seen_from_above(Stage::default().diffuse(lamp, 0.0, 2.0).alpha(mode, alpha));
        let x = 2.0 / 5f64.sqrt();
        let whole = 0.6 / std::f64::consts::PI * 2.0 * 4.0 * x * x.atan();
        assert_mean(&format!("{mode:?}, alpha {alpha}"), &got, part * whole);
    }
}

#[test]
fn surroundings_without_geometry_still_have_a_colour() {
    let lamp = illuminant::a();
    let light = Stage::default().sky(lamp.scale(1e-3)).build().light_spectrum().clone();
    let ratio = |s: &Spectrum| f64::from(s.eval(650.0)) / f64::from(s.eval(450.0));
    assert!((ratio(&light) / ratio(&lamp) - 1.0).abs() < 1e-5, "{}", ratio(&light));
}

#[test]
fn a_convex_body_in_a_uniform_environment_shows_its_reflectance() {
    for reflectance in [0.2, 0.8] {
        let scene = Stage::default().diffuse(sphere(16, 1.0), reflectance, 0.0).environment(3.0).build();
        let got = along(&scene, Vec3::new(0.3, 0.2, 5.0), Vec3::NEG_Z, 8, 20_000);
        assert_mean(&format!("reflectance {reflectance}"), &got, 3.0 * f64::from(reflectance));
    }
}

#[test]
fn inside_a_glowing_sphere_light_is_a_geometric_series() {
    let (reflectance, emission) = (0.7f32, 1.5f32);
    let scene = Stage::default().diffuse(sphere(16, -1.0), reflectance, emission).build();
    for depth in [1, 2, 3, 8, 64] {
        let got = along(&scene, Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.4, -0.7, 0.6), depth, 40_000);
        let (r, e) = (f64::from(reflectance), f64::from(emission));
        assert_mean(&format!("depth {depth}"), &got, e * (1.0 - r.powi(depth as i32)) / (1.0 - r));
    }
}

#[test]
fn clear_glass_in_a_uniform_sky_cannot_be_seen() {
    // What glass does not reflect it lets through, whatever the path inside: every path ends in the same sky. Paths cut
    // off at 200 segments are too rare to matter.
    for glass in ["BK7", "SF11", "diamond"] {
        let index = library::glass(glass).expect("a known glass");
        let ball = MaterialModel::Dielectric(Dielectric {
            index,
            distribution: Roughness::SMOOTH,
            energy_compensation: false,
        });
        let scene = Stage::default().mesh(sphere(16, 1.0), ball, None).environment(3.0).build();
        for offset in [0.1, 0.5, 0.9] {
            let got = along(&scene, Vec3::new(offset, 0.05, 5.0), Vec3::NEG_Z, 200, 5_000);
            assert_mean(&format!("{glass}, {offset} off the middle"), &got, 3.0);
        }
    }
}

/// A clear closed volume of glTF's kind with constant absorption.
fn filled(absorption_per_m: f32, index: f64) -> MaterialModel {
    MaterialModel::Layered(Box::new(LayeredDescription {
        index: Dispersion::constant(index),
        roughness: TexturedFactor::plain(0.0),
        transmission: TexturedFactor::plain(1.0),
        absorption_per_m: Some(Spectrum::constant(absorption_per_m)),
        ..LayeredDescription::default()
    }))
}

#[test]
fn a_slab_absorbs_by_beer_and_lamberts_law() {
    // A slab of thickness d, index n, seen along its normal in front of a uniform sky. With R = ((n − 1)/(n + 1))² at
    // each face and T = exp(−σd): transmitted (1 − R)²T/(1 − R²T²), reflected R + R(1 − R)²T²/(1 − R²T²).
    for (sigma, index, d) in [(0.0f64, 1.0, 0.5f32), (2.0, 1.0, 0.5), (3.0, 1.5, 0.2), (0.7, 2.4, 1.0)] {
        let front = square(Vec3::Z * d, Vec3::X, Vec3::Y, 1000.0);
        let back = square(Vec3::ZERO, Vec3::Y, Vec3::X, 1000.0);
        let slab = [front, back].concat();
        let scene = Stage::default().mesh(slab, filled(sigma as f32, index), None).environment(3.0).build();
        let got = along(&scene, Vec3::new(0.1, 0.2, 5.0), Vec3::NEG_Z, 200, 20_000);
        let (r, t) = (((index - 1.0) / (index + 1.0)).powi(2), (-sigma * f64::from(d)).exp());
        let series = (1.0 - r).powi(2) * t / (1.0 - (r * t).powi(2));
        assert_mean(&format!("σ {sigma} n {index} d {d}"), &got, 3.0 * (series + r + r * series * t));
    }
}

#[test]
fn within_a_volume_light_is_absorbed_on_the_way_to_the_eye() {
    // Camera and a glowing wall in the same volume without an interface: L·exp(−σd).
    let cube = sphere(16, 10.0);
    let wall = square(Vec3::ZERO, Vec3::X, Vec3::Y, 0.5);
    let scene = Stage::default().mesh(cube, filled(0.3, 1.0), None).diffuse(wall, 0.0, 2.0).build();
    let got = along(&scene, Vec3::Z * 20.0, Vec3::NEG_Z, 16, 1000);
    // The sphere of triangles is entered where its facet over the pole lies: between 10·cos(π/32) and 10 m.
    let (low, high) = (2.0 * (-0.3f64 * 10.0).exp(), 2.0 * (-0.3 * 10.0 * (PI / 32.0).cos()).exp());
    assert!((low - 1e-6..=high + 1e-6).contains(&got.mean()), "{} is not within {low} to {high}", got.mean());
}

#[test]
fn four_paths_from_a_surface_have_a_quarter_of_the_variance() {
    // The sun lights the floor and a slope, which the floor alone finds by chance.
    let slope = square(Vec3::new(2.0, 1.2, 0.0), Vec3::new(1.0, 1.0, 0.0).normalize(), Vec3::NEG_Z, 1.5);
    let scene = Stage::default()
        .diffuse(square(Vec3::ZERO, Vec3::X, Vec3::NEG_Z, 100.0), 0.6, 0.0)
        .diffuse(slope, 0.8, 0.0)
        .light(lamp(LightKind::Directional(DirectionalLight), DVec3::ZERO, 5.0))
        .build();
    let of = |splitting| {
        let limits = PathLimits { max_depth: 3, roulette_depth: 5, splitting };
        along_within(&scene, Vec3::new(0.0, 1.0, 1.0), Vec3::new(0.0, -1.0, -1.0), limits, 20_000)
    };
    let (one, four) = (of(1), of(4));
    assert_mean("four", &four, one.mean());
    // Light is found or not, about half of the time: a variance of 20 000 has a standard deviation below 1.5 %.
    let ratio = one.variance() / four.variance();
    assert!((ratio / 4.0 - 1.0).abs() < 4.5 * 0.015 * 2f64.sqrt(), "{ratio}");
}

#[rstest]
fn a_dispersed_path_carries_its_hero_for_all_four_wavelengths(#[values(1, 3)] splitting: u32) {
    // Where several paths go on from a white floor beside the glass, each loses its wavelengths by itself.
    let glass = MaterialModel::Dielectric(Dielectric {
        index: library::glass("SF11").expect("a known glass"),
        distribution: Roughness::SMOOTH,
        energy_compensation: false,
    });
    let floor = square(Vec3::new(0.0, 0.0, -1.2), Vec3::X, Vec3::Y, 50.0);
    let stage = Stage::default().mesh(sphere(16, 1.0), glass, None).environment(2.0);
    let (scene, x) = if splitting == 1 { (stage.build(), 0.5) } else { (stage.diffuse(floor, 1.0, 0.0).build(), 1.1) };
    let limits = PathLimits { max_depth: 200, roulette_depth: 5, splitting };
    let mut sampler = Sampler::new(SamplerKind::Independent, 3);
    let estimates: Moments = (0..20_000)
        .map(|index| {
            sampler.start(1, index);
            // Each of the four is the hero equally often, as rotation in the wavelength sampler makes it.
            let lambda = [0, 1, 2, 3].map(|lane| 450.0 + 50.0 * ((lane + index) % 4) as f32);
            let mut wavelengths = Wavelengths::new(lambda, [0.01; 4]);
            let ray = Ray::new(Vec3::new(x, 0.05, 5.0), Vec3::NEG_Z);
            let arriving = radiance(&scene, ray, &mut wavelengths, &mut sampler, limits);
            f64::from((arriving * wavelengths.weights()).0.element_sum())
        })
        .collect();
    // Σ over the lanes of L/(4·p) = 2/0.01 on average, however many lanes are left.
    assert_mean("SF11", &estimates, 200.0);
}
