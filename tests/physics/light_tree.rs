//! The light of many lamps together, against the sum of what each gives.

use std::f64::consts::PI;

use glam::{DAffine3, DVec3, Vec3};
use photosite::light::{PointLight, SpotLight};
use photosite::math::statistics::Moments;
use photosite::scene::Scene;
use photosite::scene::description::{
    Colour, Diffuse, EmissionDescription, LightDescription, LightKind, MaterialModel, TexturedColour, Translucent,
};
use photosite::spectrum::Spectrum;
use rstest::rstest;

use crate::stage::{Stage, square};
use crate::transport::{along, assert_mean};

/// Numbers from 0 to 1 that fill the line evenly.
fn even(i: usize, base: usize) -> f64 {
    let (mut i, mut part, mut sum) = (i + 1, 1.0, 0.0);
    while i > 0 {
        part /= base as f64;
        sum += part * (i % base) as f64;
        i /= base;
    }
    sum
}

/// Irradiance on the side of `normal` at the origin from the front of a polygon of radiance 1 that is wholly on that
/// side (Lambert 1760).
fn from_polygon(corners: [DVec3; 4], normal: DVec3) -> f64 {
    let edge = |i: usize| {
        let (a, b) = (corners[i].normalize(), corners[(i + 1) % 4].normalize());
        a.angle_between(b) * b.cross(a).normalize_or_zero().dot(normal)
    };
    (0.5 * (0..4).map(edge).sum::<f64>()).max(0.0)
}

/// Corners of 3000 small squares over (`side` = 1) or under (−1) a sheet at y = 0, turned all ways. They hide less than
/// a thousandth of each other.
fn squares(side: f64) -> Vec<[Vec3; 4]> {
    let one = |i: usize| {
        let [x, y, z, a, b] = [2, 3, 5, 7, 11].map(|base| even(i, base));
        let centre = DVec3::new(12.0 * x - 6.0, side * (0.3 + 2.0 * y), 12.0 * z - 6.0);
        let turn = glam::DQuat::from_rotation_y(2.0 * PI * a) * glam::DQuat::from_rotation_x(PI * b);
        let half = 0.002;
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(u, v)| (centre + turn * DVec3::new(u, 0.0, v) * half).as_vec3())
    };
    (0..3000).map(one).collect()
}

fn triangles(squares: &[[Vec3; 4]]) -> Vec<[Vec3; 3]> {
    squares.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect()
}

/// From squares of radiance 1 at the origin, W·m⁻²·nm⁻¹.
fn irradiance(squares: &[[Vec3; 4]], normal: DVec3) -> f64 {
    squares.iter().map(|corners| from_polygon(corners.map(|c| c.as_dvec3()), normal)).sum()
}

fn sheet(stage: Stage, reflectance: f32, transmittance: f32) -> Stage {
    let plain = |value| TexturedColour::plain(Colour::Spectrum(Spectrum::constant(value)));
    let model = if transmittance > 0.0 {
        MaterialModel::Translucent(Translucent { reflectance: plain(reflectance), transmittance: plain(transmittance) })
    } else {
        MaterialModel::Diffuse(Diffuse { reflectance: plain(reflectance) })
    };
    stage.mesh(square(Vec3::ZERO, Vec3::X, Vec3::NEG_Z, 20.0), model, None)
}

/// The sheet from above.
fn seen(scene: &Scene) -> Moments {
    along(scene, Vec3::new(0.0, 0.05, 0.05), Vec3::new(0.0, -1.0, -1.0), 2, 40_000)
}

/// A lamp over the sheet that shines straight down.
fn lamp(i: usize, kind: LightKind) -> LightDescription {
    let [x, y, z] = [2, 3, 5].map(|base| even(i, base));
    let position = DVec3::new(6.0 * x - 3.0, 0.4 + y, 6.0 * z - 3.0);
    let emission =
        EmissionDescription { colour: Colour::Spectrum(Spectrum::constant(0.001)), level: None, texture: None };
    let down = glam::DQuat::from_rotation_x(-PI / 2.0);
    let to_world = DAffine3::from_rotation_translation(down, position);
    LightDescription { name: String::new(), to_world, later: Vec::new(), kind, emission }
}

#[rstest]
#[case::that_reflects(0.6, 0.0)]
#[case::that_transmits_too(0.5, 0.3)]
fn a_sheet_among_thousands_of_small_squares_gets_the_sum_of_their_form_factors(
    #[case] reflectance: f32,
    #[case] transmittance: f32,
) {
    let (above, below) = (squares(1.0), squares(-1.0));
    let stage = Stage::default().diffuse(triangles(&above), 0.0, 1.0).diffuse(triangles(&below), 0.0, 2.0);
    let scene = sheet(stage, reflectance, transmittance).build();
    let (front, back) = (irradiance(&above, DVec3::Y), 2.0 * irradiance(&below, DVec3::NEG_Y));
    let expected = (f64::from(reflectance) * front + f64::from(transmittance) * back) / PI;
    let got = seen(&scene);
    assert_mean("squares", &got, expected);
    // Chosen by their power alone, they would leave 3 % at as many paths.
    assert!(got.variance_of_mean().sqrt() < 0.01 * expected, "{got:?}");
}

#[test]
fn hundreds_of_points_and_spots_give_the_sum_of_their_irradiances() {
    let outer_rad = 0.5f32;
    let mut stage = Stage::default();
    let mut expected = 0.0;
    for i in 0..800 {
        let kind =
            if i % 2 == 0 { LightKind::Point(PointLight) } else { LightKind::Spot(SpotLight::new(0.0, outer_rad)) };
        let lamp = lamp(i, kind.clone());
        let world_to_light = lamp.to_world.translation;
        let cos = world_to_light.y / world_to_light.length();
        let outer = f64::from(outer_rad).cos();
        let part = if i % 2 == 0 { 1.0 } else { ((cos - outer) / (1.0 - outer)).max(0.0).powi(2) };
        expected += 0.001 * part * cos / world_to_light.length_squared();
        stage = stage.light(lamp);
    }
    let scene = sheet(stage, 0.6, 0.0).build();
    let got = seen(&scene);
    assert_mean("lamps", &got, 0.6 / PI * expected);
}
