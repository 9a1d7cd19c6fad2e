//! Light sampling: directions against their densities, and estimates against the light that arrives.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use photosite::geometry::{QuadricKind, Ray};
use photosite::light::{Facing, LightSampleContext, PointLight};
use photosite::scene::Scene;
use photosite::scene::description::{
    Colour, EmissionDescription, EnvironmentDescription, ImageLevel, LightDescription, LightKind,
};
use photosite::spectrum::{Spectrum, Wavelengths};
use photosite::texture::{Bitmap, Texels};

use rstest::rstest;

use crate::bsdf_cases::{SAMPLES, Uniform};
use crate::bsdf_sampling::{COLUMNS, ROWS, bin, p_value};
use crate::quadrature::{Cell, direction};
use crate::stage::{Stage, square};

const HERE: LightSampleContext = LightSampleContext::anywhere(Vec3::ZERO);

fn lambda() -> Wavelengths {
    Wavelengths::new([450.0, 500.0, 550.0, 600.0], [1.0; 4])
}

/// A dim sky with a sun of one texel, 16 × 8, turned by 40°.
fn sky(level: f64) -> EnvironmentDescription {
    let mut texels = vec![[0.2f32; 3]; 128];
    texels[2 * 16 + 5] = [60.0, 50.0, 40.0];
    let image = Arc::new(Bitmap { name: "sky".into(), width: 16, height: 8, texels: Texels::Rgb32F(texels) });
    EnvironmentDescription::Image { image, level: ImageLevel::NitPerUnit(level), rotation_deg: 40.0 }
}

/// A shining quadric of that size.
fn quadric(kind: QuadricKind, size: DVec3, place: DVec3, two_sided: bool) -> Stage {
    let to_world = DAffine3::from_scale_rotation_translation(size, DQuat::IDENTITY, place);
    Stage::default().quadric(kind, to_world, 0.0, (1.0, two_sided))
}

/// Density of the direction `wi` from the origin: that of the lamp met there, if it shines this way, and that of the
/// sky.
fn density(scene: &Scene, wi: Vec3) -> f64 {
    let of_lamp = scene.closest(&Ray::new(Vec3::ZERO, wi)).map_or(0.0, |hit| {
        let point = scene.point(&hit, 0.0);
        let cos = -wi.dot(point.geometric_normal);
        let light = scene.light_of(&point).filter(|_| !scene.emitted(&point, -wi, &lambda()).is_black());
        light.map_or(0.0, |light| scene.lights().area_light_pdf(light, &HERE, scene.geometry(), 0.0, hit.t, cos).0)
    });
    f64::from(of_lamp + scene.lights().environment_pdf(&HERE, wi).0)
}

/// How many samples are expected in each bin, and in one more for those that find no light: the midpoint rule, since
/// the edges of lamps and texels make jumps. A bin cut by an edge is off by less than a part in 48, most by far less.
fn expectation(scene: &Scene) -> Vec<f64> {
    let n = 48;
    let at = |[low, high]: [f64; 2], i: usize| low + (high - low) * (i as f64 + 0.5) / n as f64;
    let count = |cell: &Cell| {
        let sum: f64 = (0..n * n).map(|i| density(scene, direction(at(cell.z, i / n), at(cell.phi, i % n)))).sum();
        sum / (n * n) as f64 * 2.0 * TAU / (ROWS * COLUMNS) as f64 * SAMPLES as f64
    };
    // A bin of which a lamp takes a rim only may come out as 0, and is pooled with others.
    let mut expected: Vec<f64> = Cell::sphere(ROWS, COLUMNS).iter().map(|cell| count(cell).max(1e-6)).collect();
    expected.push((SAMPLES as f64 - expected.iter().sum::<f64>()).max(1e-6));
    expected
}

#[test]
fn directions_to_light_are_distributed_as_the_density_says() {
    let lamp = || square(Vec3::new(0.2, 0.1, 0.8), Vec3::X, Vec3::NEG_Y, 0.7);
    // A radiance of 1 W·m⁻²·sr⁻¹·nm⁻¹ over the visible is some 7·10⁴ nit: lamp and sky are chosen about equally.
    // Towards the outline of a cylinder the density goes as 1/cos, which the midpoint rule does not sum up: from outside its
    // samples are held to rays in `light/emitter/tests.rs`.
    for (what, stage) in [
        ("sky", Stage::default().surroundings(sky(1e3))),
        ("lamp", Stage::default().diffuse(lamp(), 0.0, 1.0)),
        ("lamp under the sky", Stage::default().diffuse(lamp(), 0.0, 1.0).surroundings(sky(1e4))),
        ("lamp in uniform light", Stage::default().diffuse(lamp(), 0.0, 1.0).environment(0.1)),
        ("sphere", quadric(QuadricKind::Sphere, DVec3::ONE, DVec3::new(0.8, 0.9, 0.3), false)),
        ("sphere that nearly touches", quadric(QuadricKind::Sphere, DVec3::ONE, DVec3::new(0.6, 0.801, 0.0), false)),
        ("sphere from inside", quadric(QuadricKind::Sphere, DVec3::ONE, DVec3::new(0.5, -0.7, 0.3), true)),
        ("disk", quadric(QuadricKind::Disk, DVec3::splat(0.8), DVec3::new(0.3, 0.1, -0.5), false)),
        ("disk from behind", quadric(QuadricKind::Disk, DVec3::splat(0.8), DVec3::new(0.3, 0.1, 0.5), true)),
        ("cylinder before an end", quadric(QuadricKind::Cylinder, DVec3::ONE, DVec3::new(0.2, 0.4, 0.3), true)),
        ("cylinder from inside", quadric(QuadricKind::Cylinder, DVec3::ONE, DVec3::new(0.2, 0.4, -0.4), true)),
    ] {
        let scene = stage.build();
        let mut uniform = Uniform::new(7);
        let expected = expectation(&scene);
        let (mut observed, mut misjudged) = (vec![0.0; expected.len()], 0);
        for _ in 0..SAMPLES {
            let (_, u) = uniform.lobe_and_direction();
            let Some(sample) = scene.sample_light(&HERE, 0.0, u, &lambda()) else {
                observed[expected.len() - 1] += 1.0;
                continue;
            };
            observed[bin(sample.wi)] += 1.0;
            // A sample of the lamp does not know of the sky behind it, nor the other way round.
            misjudged += u32::from(f64::from(sample.pdf.0) > density(&scene, sample.wi) * 1.001);
        }
        // Rounding takes a direction across the edge of a lamp or a texel, which are some 1e-5 of all.
        assert!(misjudged < 20, "{what}: {misjudged} densities of {SAMPLES} are not those of the direction");
        let p = p_value(&observed, &expected);
        // The seed is fixed, so this either passes for good or the sampler is wrong.
        assert!(p > 1e-3, "{what}: p = {p:e}");
    }
}

#[test]
fn the_sky_is_sampled_where_it_is_bright() {
    let scene = Stage::default().surroundings(sky(1e3)).build();
    // By hand: a texel's weight is its luminance and the mean of that and those around, in equal parts, as far as it
    // exceeds the mean of the sky, times the sine of its row. The sun is in row 2; e is the weight of the eight texels
    // about it.
    let sun = 0.2126 * 60.0 + 0.7152 * 50.0 + 0.0722 * 40.0;
    let around = (sun + 8.0 * 0.2) / 9.0;
    let sines: [f64; 8] = std::array::from_fn(|row| (PI * (row as f64 + 0.5) / 8.0).sin());
    let [above, own, below] = [sines[1], sines[2], sines[3]];
    let (sun, edge) = (0.5 * (sun + around), 0.5 * (0.2 + around));
    let others = 16.0 * sines.iter().sum::<f64>();
    let excess = (sun - 0.2) * own + (edge - 0.2) * (2.0 * own + 3.0 * (above + below));
    let mean = 0.2 + excess / others;
    let (c, e) = (sun - mean, edge - mean);
    // Interpolation makes bright the sun's own texel, half of the four beside it and a quarter of the four at its
    // corners.
    let bright_weight = c * own + e * (own + 0.5 * (above + below) + 0.5 * (above + below));
    let expected = bright_weight / (c * own + e * (2.0 * own + 3.0 * (above + below)));
    let mut uniform = Uniform::new(8);
    let n = 20_000;
    let mut bright = 0.0;
    for _ in 0..n {
        let (_, u) = uniform.lobe_and_direction();
        let sample = scene.sample_light(&HERE, 0.0, u, &lambda()).expect("the sky is everywhere");
        bright +=
            f64::from(u8::from(sample.radiance[2] > 1.001 * scene.environment_radiance(Vec3::NEG_Y, &lambda())[2]));
    }
    let part = bright / f64::from(n);
    // Five standard errors. Uniform directions would find the bright area 5 times in 100.
    let sigma = (expected * (1.0 - expected) / f64::from(n)).sqrt();
    assert!((part - expected).abs() < 5.0 * sigma, "{part} of the samples, not {expected} ± {sigma}");
}

/// A point light of constant intensity, W·sr⁻¹·nm⁻¹.
fn point_light(position: DVec3, intensity: f32) -> LightDescription {
    let colour = Colour::Spectrum(Spectrum::constant(intensity));
    LightDescription {
        name: String::new(),
        to_world: DAffine3::from_translation(position),
        later: Vec::new(),
        kind: LightKind::Point(PointLight),
        emission: EmissionDescription { colour, level: None, texture: None },
    }
}

#[rstest]
#[case::by_distance(DVec3::X * 2.0, Facing::Anywhere, 0.03 / 4.0)]
#[case::by_cosine(DVec3::new(0.6, 0.0, 0.8), Facing::Front(Vec3::X), 0.03 * 0.6)]
#[case::not_behind_what_reflects(DVec3::new(-0.6, 0.0, 0.8), Facing::Front(Vec3::X), 0.0)]
#[case::behind_what_transmits(DVec3::new(-0.6, 0.0, 0.8), Facing::Both(Vec3::X), 0.03 * 0.6)]
fn lamps_are_chosen_by_what_they_give(#[case] second: DVec3, #[case] facing: Facing, #[case] expected: f64) {
    let scene = Stage::default().light(point_light(DVec3::X, 0.01)).light(point_light(second, 0.03)).build();
    let receiver = LightSampleContext { point: Vec3::ZERO, facing };
    let n = 4000;
    let mut found = 0.0;
    for i in 0..n {
        let u_light = (i as f32 + 0.5) / n as f32;
        let sample = scene.sample_light(&receiver, 0.0, [u_light, 0.4], &lambda()).expect("all can be seen");
        let (position, _) = sample.position.expect("a lamp");
        let is_second = position.distance(second.as_vec3()) < 1e-6;
        found += f64::from(u8::from(is_second)) / f64::from(n);
    }
    let expected = expected / (expected + 0.01);
    // Equally spaced numbers: an interval is off by one step at most at either end.
    assert!((found - expected).abs() < 2.0 / f64::from(n), "{found} instead of {expected}");
}

#[test]
fn the_triangles_of_a_rectangle_are_chosen_by_their_area() {
    let [a, b, c, d] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 0.0)].map(|(x, y)| Vec3::new(x, y, 1.0));
    let scene = Stage::default().diffuse(vec![[a, c, b], [a, d, c]], 0.0, 1.0).build();
    let n = 4000;
    let expected = 2.0 / 3.0;
    let found = (0..n).filter(|i| {
        let u_light = (*i as f32 + 0.5) / n as f32;
        let sample = scene.sample_light(&HERE, 0.0, [u_light, 0.4], &lambda()).expect("all can be seen");
        let (p, _) = sample.position.expect("a lamp");
        p.x > p.y
    });
    let found = found.count() as f64 / f64::from(n);
    assert!((found - expected).abs() < 2.0 / f64::from(n), "{found} instead of {expected}");
}
