//! Paths from lamps: the same light as without them, through every material and lens, and less noise in caustics.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3};
use photosite::film::{Film, FilmResponses, Response};
use photosite::image::{Estimate, Planes};
use photosite::integrator::{LightPathKind, RenderJob, RenderSettings, render, render_on};
use photosite::optics::{
    BrownConrady, Falloff, Focus, Intrinsics, LateralColour, LensDescription, LensKind, PixelGrid, PointSpread,
    Projection, Stop,
};
use photosite::sampler::SamplerKind;
use photosite::scene::Scene;
use photosite::scene::description::{
    AlphaMode, CoatDescription, Colour, Conductor, Dielectric, Diffuse, EmissionDescription, LayeredDescription,
    MaterialModel, Mix, Phong, Roughness, TexturedColour, TexturedFactor, ThinDielectric,
};
use photosite::spectrum::{Dispersion, Spectrum, library};
use rstest::rstest;

use crate::prescription::described;
use crate::stage::{Stage, camera, sphere, square};

pub(crate) const RESOLUTION: [u32; 2] = [8, 6];
const BANDS: [&str; 2] = ["short", "long"];

pub(crate) fn grey(value: f32) -> TexturedColour {
    TexturedColour::plain(Colour::Spectrum(Spectrum::constant(value)))
}

pub(crate) fn glass(roughness: f32) -> MaterialModel {
    MaterialModel::Dielectric(Dielectric {
        index: Dispersion::constant(1.5),
        distribution: Roughness::isotropic(roughness),
        energy_compensation: false,
    })
}

pub(crate) fn gold(roughness: f32) -> MaterialModel {
    let metal = library::conductor("Au").expect("a metal");
    MaterialModel::Conductor(Conductor {
        eta: metal.eta,
        k: metal.k,
        distribution: Roughness::isotropic(roughness),
        energy_compensation: false,
    })
}

fn layers(layers: LayeredDescription) -> MaterialModel {
    MaterialModel::Layered(Box::new(LayeredDescription { base_colour: grey(0.8), ..layers }))
}

fn varnish() -> CoatDescription {
    let plain = TexturedFactor::plain;
    CoatDescription { weight: plain(1.0), roughness: plain(0.2), normal_map: None }
}

/// A ball of a material in a room of 4 m under a lamp, seen from the front.
pub(crate) fn room(model: MaterialModel) -> Stage {
    let shine = Spectrum::from_fn(|l| 1.0 + l / 500.0);
    let emission = EmissionDescription { colour: Colour::Spectrum(shine), level: None, texture: None };
    let ball = sphere(12, 0.5).into_iter().map(|triangle| triangle.map(|corner| corner + Vec3::new(0.1, 0.3, -0.5)));
    Stage::default()
        .diffuse(sphere(6, -3.0), 0.5, 0.0)
        .mesh(
            square(Vec3::new(-0.2, 1.7, 0.1), Vec3::X, Vec3::Z, 0.35),
            MaterialModel::Diffuse(Diffuse { reflectance: grey(0.2) }),
            Some(emission),
        )
        .mesh(ball.collect(), model, None)
}

/// The room with a screen under its lamp, whose light comes by way of the ceiling.
pub(crate) fn screened(model: MaterialModel) -> Stage {
    room(model).diffuse(square(Vec3::new(-0.2, 1.4, 0.1), Vec3::Z, Vec3::X, 0.8), 0.5, 0.0)
}

/// A pinhole at z = 2.2 that sees the ball and the wall behind.
pub(crate) fn lens() -> LensDescription {
    LensDescription { kind: LensKind::Pinhole, ..LensDescription::thin(0.01, 4.0, Focus::Distance(2.5)) }
}

fn with_light_paths() -> RenderSettings {
    RenderSettings { light_paths: Some(1.0), ..RenderSettings::default() }
}

pub(crate) fn image(
    scene: &Scene,
    lens: &LensDescription,
    settings: RenderSettings,
    prepare: impl FnOnce(&mut Film),
) -> Estimate {
    let grid = PixelGrid { resolution: RESOLUTION, pitch_m: [2e-3; 2] };
    let camera = camera(
        lens,
        &grid,
        DAffine3::from_rotation_translation(DQuat::from_rotation_x(-0.5), DVec3::new(0.0, 0.1, 2.2)),
    );
    let band = |from: f64, to: f64| Spectrum::from_fn(|l| if l >= from && l < to { 1e-3 } else { 0.0 });
    let responses = [(BANDS[0], band(400.0, 550.0)), (BANDS[1], band(550.0, 700.0))]
        .map(|(name, spectrum)| Response::new(name, spectrum));
    let settings =
        RenderSettings { samples_per_pixel: 1 << 13, max_depth: 6, sampler: SamplerKind::Independent, ..settings };
    let job = RenderJob {
        scene,
        camera: &camera,
        transmittance: &Spectrum::from_fn(|l| 0.5 + l / 2000.0),
        responses: &responses,
        filters: None,
        importance: None,
        resolution: RESOLUTION,
        settings: &settings,
        device: None,
    };
    let mut film = job.empty_film(FilmResponses::new(&responses));
    prepare(&mut film);
    render_on(&job, &mut film, &|_| ControlFlow::Continue(()));
    film.estimate(BANDS)
}

/// Renders as the settings say, and with paths from the camera alone, and compares both pixel by pixel. Returns the
/// variance without over that with them, of all pixels together.
pub(crate) fn compare(name: &str, scene: &Scene, lens: &LensDescription, settings: RenderSettings) -> f64 {
    let alone = RenderSettings { light_paths: None, seed: 2, ..settings.clone() };
    let [without, with] = [alone, settings].map(|settings| image(scene, lens, settings, |_| {}));
    let values = |estimate: &Estimate, is_mean: bool| -> Vec<f64> {
        let planes = if is_mean { &estimate.mean } else { &estimate.variance };
        planes.channels().iter().flat_map(|channel| &channel.data).map(|&v| f64::from(v)).collect()
    };
    let [mean, more_mean] = [&without, &with].map(|estimate| values(estimate, true));
    let [variance, more_variance] = [&without, &with].map(|estimate| values(estimate, false));
    let difference: f64 = mean.iter().zip(&more_mean).map(|(a, b)| b - a).sum();
    // Both bands of a pixel come from the same paths: their errors may be all one, √2 of independent ones.
    let error = (2.0 * variance.iter().chain(&more_variance).sum::<f64>()).sqrt();
    assert!(difference.abs() < 4.0 * error, "{name}: all pixels differ by {difference} ± {error}");
    // χ² of all pixels, pooled: where light is rare, single pixels do not know their variance. Means of 2¹³ samples are
    // normal, so that the square of a difference of variance σ² has the variance 2σ⁴, and twice as much if both bands
    // are one: 4 standard deviations of Σσ².
    let squares: f64 = mean.iter().zip(&more_mean).map(|(a, b)| (b - a).powi(2)).sum();
    let of_differences: Vec<f64> = variance.iter().zip(&more_variance).map(|(a, b)| a + b).collect();
    let sum: f64 = of_differences.iter().sum();
    let sigma = (4.0 * of_differences.iter().map(|v| v * v).sum::<f64>()).sqrt();
    assert!(squares < sum + 4.0 * sigma, "{name}: χ² per pixel {}, not 1 ± {}", squares / sum, sigma / sum);
    variance.iter().sum::<f64>() / more_variance.iter().sum::<f64>()
}

#[rstest]
#[case::matt(MaterialModel::Diffuse(Diffuse { reflectance: grey(0.7) }))]
#[case::rough_metal(gold(0.7))]
#[case::flat_phong(MaterialModel::Phong(Phong { diffuse: grey(0.3), specular: grey(0.6), exponent: 10.0 }))]
#[case::rough_layers(layers(LayeredDescription { roughness: TexturedFactor::plain(0.8), ..LayeredDescription::default() }))]
fn light_of_a_lamp_behind_a_screen_is_the_same_with_paths_from_it_and_quieter(#[case] model: MaterialModel) {
    let scene = screened(model).build();
    assert!(!scene.may_cast_caustics());
    for settings in [with_light_paths(), RenderSettings { splitting: Some(3), ..with_light_paths() }] {
        let ratio = compare("screen", &scene, &lens(), settings);
        assert!(ratio > 2.0, "{ratio}");
    }
}

#[test]
fn light_is_the_same_with_paths_from_lamps_and_caustics_are_quieter() {
    let rough = TexturedFactor::plain;
    let clear = LayeredDescription { transmission: rough(1.0), roughness: rough(0.1), ..LayeredDescription::default() };
    // By how much the variance falls at least: caustics of narrow lobes are most of what there is. As measured, to
    // notice when light paths find less.
    let cases = [
        ("glass", glass(0.0), 10.0),
        ("rough glass", glass(0.3), 10.0),
        (
            "dispersing glass",
            MaterialModel::Dielectric(Dielectric {
                index: library::glass("SF11").expect("a glass"),
                distribution: Roughness::SMOOTH,
                energy_compensation: false,
            }),
            10.0,
        ),
        (
            "rough dispersing glass",
            MaterialModel::Dielectric(Dielectric {
                index: library::glass("SF11").expect("a glass"),
                distribution: Roughness::isotropic(0.3),
                energy_compensation: false,
            }),
            10.0,
        ),
        ("mirror", gold(0.0), 4.0),
        ("gold", gold(0.3), 3.0),
        (
            "pane",
            MaterialModel::ThinDielectric(ThinDielectric {
                index: Dispersion::constant(1.5),
                transmittance: Spectrum::constant(0.9),
            }),
            7.0,
        ),
        ("Phong", MaterialModel::Phong(Phong { diffuse: grey(0.2), specular: grey(0.7), exponent: 100.0 }), 2.0),
        ("mix", MaterialModel::Mix(Box::new(Mix { models: [gold(0.1), glass(0.0)], weight: 0.5 })), 3.0),
        ("varnish", layers(LayeredDescription { coat: Some(varnish()), ..LayeredDescription::default() }), 1.5),
        (
            "metal",
            layers(LayeredDescription { metallic: rough(1.0), roughness: rough(0.3), ..LayeredDescription::default() }),
            3.0,
        ),
        ("clear sheet", layers(clear.clone()), 10.0),
        (
            "clear body",
            layers(LayeredDescription { absorption_per_m: Some(Spectrum::from_fn(|l| l / 1000.0)), ..clear }),
            8.0,
        ),
        // No interface at all, as glTF's index of 1: straight through, whatever the roughness.
        (
            "nothing",
            MaterialModel::Dielectric(Dielectric {
                index: Dispersion::constant(1.0),
                distribution: Roughness::isotropic(0.8),
                energy_compensation: false,
            }),
            2.0,
        ),
        // Too dull to gather light: nothing changes, and two estimates of the variance differ by chance.
        ("dull metal", gold(0.8), 0.0),
    ];
    for (name, model, least) in cases {
        let gain = compare(name, &room(model).build(), &lens(), with_light_paths());
        assert!(gain > least, "{name}: {gain}");
    }
}

#[rstest]
#[case::glass(glass(0.0))]
#[case::gold(gold(0.3))]
#[case::varnish(layers(LayeredDescription { coat: Some(varnish()), ..LayeredDescription::default() }))]
fn all_indirect_light_is_the_same_with_paths_from_a_lamp_where_something_is_polished(#[case] model: MaterialModel) {
    let scene = screened(model).build();
    assert_eq!(LightPathKind::of(&scene), [LightPathKind::Caustics, LightPathKind::Indirect]);
    let settings = RenderSettings { light_path_kind: Some(LightPathKind::Indirect), ..with_light_paths() };
    let ratio = compare("screen", &scene, &lens(), settings);
    assert!(ratio > 2.0, "{ratio}");
}

#[test]
fn paths_from_lamps_come_through_every_lens() {
    let thin = || LensDescription::thin(0.01, 0.2, Focus::Distance(1.1));
    let pitch = |fx: f64| Some(Intrinsics { fx, fy: 1.1 * fx, cx: 4.3, cy: 2.8, skew: 0.1 });
    let barrel =
        Projection::BrownConrady(BrownConrady { k: [-0.05, 0.0, 0.0, 0.0, 0.0, 0.0], ..BrownConrady::default() });
    let lenses = [
        ("out of focus", thin()),
        ("barrel", LensDescription { projection: barrel, intrinsics: pitch(5.0), ..thin() }),
        (
            "fisheye",
            LensDescription { projection: Projection::KannalaBrandt { k: [0.0; 4] }, intrinsics: pitch(3.0), ..thin() },
        ),
        ("panorama", LensDescription { projection: Projection::Equirectangular, intrinsics: pitch(1.2), ..lens() }),
        (
            "lateral colour",
            LensDescription {
                lateral_colour: Some(LateralColour { points: vec![(400.0, 0.8), (700.0, 1.2)] }),
                ..thin()
            },
        ),
        ("blur", LensDescription { point_spread: Some(PointSpread::Gaussian { sigma_m: 1.5e-3 }), ..lens() }),
        ("vignetted", LensDescription { stops: vec![Stop { distance_m: 0.02, radius_m: 0.03 }], ..thin() }),
    ];
    let scene = room(glass(0.0)).build();
    for (name, lens) in lenses {
        let gain = compare(name, &scene, &lens, with_light_paths());
        // The panorama sees the lamp, whose edge is then most of the noise.
        let least = if name == "panorama" { 1.0 } else { 2.5 };
        assert!(gain > least, "{name}: {gain}");
    }
}

/// Wide lenses from prescriptions: out of focus, beyond the image circle, with blades; paths with four wavelengths that
/// land each in a pixel of its own, and with the hero alone.
#[test]
fn paths_from_lamps_come_through_the_glass_of_a_prescription() {
    let dispersing = || {
        MaterialModel::Dielectric(Dielectric {
            index: library::glass("SF11").expect("a glass"),
            distribution: Roughness::SMOOTH,
            energy_compensation: false,
        })
    };
    let splitting = RenderSettings { splitting: Some(2), ..with_light_paths() };
    let cases = [
        ("nikkor-z14", 4.0, 0, glass(0.0), with_light_paths()),
        ("nikkor-z14", 8.0, 5, gold(0.1), with_light_paths()),
        ("canon-rf24", 1.8, 0, dispersing(), with_light_paths()),
        ("canon-rf24", 4.0, 7, dispersing(), splitting),
        ("fisheye-170", 2.0, 0, glass(0.0), with_light_paths()),
    ];
    for (name, f_number, blades, model, settings) in cases {
        let (description, _) = described(name, f_number);
        let lens = LensDescription { blades, ..description };
        let gain = compare(name, &room(model).build(), &lens, settings);
        // The fisheye sees the lamp, whose edge is then most of the noise. As measured: 32, 6.3, 14, 7.1, 1.2.
        let least = if name == "fisheye-170" { 1.0 } else { 4.0 };
        assert!(gain > least, "{name}: {gain}");
    }
}

#[test]
fn light_by_way_of_a_mirror_is_that_of_the_lamps_image() {
    // A lamp of 20 cm a metre above a mirror shines down; the ceiling above it sees its image only, a metre below the
    // mirror.
    let (half, radiance, reflectance) = (0.1f32, 3.0, 0.5);
    let metal = |eta, k| {
        MaterialModel::Conductor(Conductor {
            eta: Spectrum::constant(eta),
            k: Spectrum::constant(k),
            distribution: Roughness::SMOOTH,
            energy_compensation: false,
        })
    };
    let scene = Stage::default()
        .diffuse(square(Vec3::Y, Vec3::X, Vec3::Z, half), 0.0, radiance)
        .mesh(square(Vec3::ZERO, Vec3::Z, Vec3::X, 5.0), metal(0.0, 1.0), None)
        .diffuse(square(2.0 * Vec3::Y, Vec3::X, Vec3::Z, 5.0), reflectance, 0.0)
        .build();
    // Straight up to a square metre of the ceiling, from half a metre below it.
    let mut lens = LensDescription { kind: LensKind::Pinhole, ..LensDescription::thin(0.1, 4.0, Focus::Infinity) };
    lens.falloff = Falloff::None;
    let (n, middle) = (8u32, 1.5);
    let up = DAffine3::from_rotation_translation(DQuat::from_rotation_x(FRAC_PI_2), DVec3::new(middle, 1.5, 0.0));
    let camera = camera(&lens, &PixelGrid { resolution: [n; 2], pitch_m: [0.2 / f64::from(n); 2] }, up);
    let spectrum = Spectrum::from_fn(|l| if (500.0..=600.0).contains(&l) { 0.01 } else { 0.0 });
    let band = spectrum.integral();
    let responses = [Response::new("E", spectrum)];
    let settings =
        RenderSettings { samples_per_pixel: 512, max_depth: 3, light_paths: Some(64.0), ..RenderSettings::default() };
    let job = RenderJob {
        scene: &scene,
        camera: &camera,
        transmittance: &Spectrum::constant(1.0),
        responses: &responses,
        filters: None,
        importance: None,
        resolution: [n; 2],
        settings: &settings,
        device: None,
    };
    let film = render(&job, FilmResponses::new(&responses), &|_| ControlFlow::Continue(()));
    let estimate = film.estimate(["E"]);
    let sum = |planes: &Planes| planes.channels()[0].data.iter().map(|&v| f64::from(v)).sum::<f64>();
    let pixels = f64::from(n * n);
    let (found, error) = (sum(&estimate.mean) / pixels, sum(&estimate.variance).sqrt() / pixels);
    // Midpoint rule over the ceiling and the image, 3 m below: E = ∫ L·cos²/d² dA.
    let steps = 12u32;
    let at = |i: u32, side: f64| side * ((f64::from(i) + 0.5) / f64::from(steps) - 0.5);
    let mut irradiance = 0.0;
    for [i, j, k, l] in (0..steps.pow(4)).map(|i| [1, steps, steps.pow(2), steps.pow(3)].map(|unit| i / unit % steps)) {
        let lamp = 2.0 * f64::from(half);
        let (dx, dz) = (middle + at(i, 1.0) - at(k, lamp), at(j, 1.0) - at(l, lamp));
        let d2 = dx * dx + dz * dz + 9.0;
        irradiance += f64::from(radiance) * lamp * lamp * 9.0 / (d2 * d2) / f64::from(steps.pow(4));
    }
    let weight = f64::from(camera.generate(DVec2::splat(4.0), [0.5; 2]).expect("a ray").weight);
    let expected = f64::from(reflectance) / PI * irradiance * weight * band;
    // Four standard errors, and what a grid of 8 cm leaves out at 3 m, 1e-4.
    assert!((found - expected).abs() < 4.0 * error + 1e-4 * expected, "{found}, not {expected} ± {error}");
    assert!(error < 0.005 * expected, "{error} of {expected}: the lamps' paths have not found it");
}

#[test]
fn paths_that_split_have_their_share_beside_those_from_lamps() {
    let gain = compare(
        "splitting",
        &room(glass(0.0)).build(),
        &lens(),
        RenderSettings { splitting: Some(4), ..with_light_paths() },
    );
    assert!(gain > 4.0, "{gain}");
}

#[test]
fn lamps_of_every_kind_send_paths_out() {
    let emission =
        || EmissionDescription { colour: Colour::Spectrum(Spectrum::constant(1.0)), level: None, texture: None };
    let dark = || MaterialModel::Diffuse(Diffuse { reflectance: grey(0.0) });
    let turned = |centre: Vec3| square(centre, Vec3::Z, Vec3::new(0.8, 0.6, 0.0), 0.2);
    let lamps = [
        ("several", room(gold(0.1)).mesh(turned(Vec3::new(-1.5, 0.5, 0.5)), dark(), Some(emission()))),
        (
            "with holes",
            room(gold(0.1))
                .mesh(turned(Vec3::new(-1.5, 0.5, 0.5)), dark(), Some(emission()))
                .alpha(AlphaMode::Blend, 0.4),
        ),
        ("in murky water", {
            // Around the lamp and the ball: all that comes out has been absorbed from the lamp on.
            let murky = LayeredDescription {
                transmission: TexturedFactor::plain(1.0),
                roughness: TexturedFactor::plain(0.0),
                absorption_per_m: Some(Spectrum::constant(0.5)),
                ..LayeredDescription::default()
            };
            let water =
                sphere(8, 1.9).into_iter().map(|t| t.map(|corner| corner + Vec3::new(0.0, 0.4, -0.4))).collect();
            room(gold(0.1)).mesh(water, layers(murky), None)
        }),
        ("within glass", {
            let shell =
                sphere(8, 0.5).into_iter().map(|t| t.map(|corner| corner + Vec3::new(-1.2, 0.3, 0.0))).collect();
            room(gold(0.1)).mesh(turned(Vec3::new(-1.2, 0.3, 0.0)), dark(), Some(emission())).mesh(
                shell,
                glass(0.0),
                None,
            )
        }),
    ];
    for (name, stage) in lamps {
        let gain = compare(name, &stage.build(), &lens(), with_light_paths());
        assert!(gain > 3.0, "{name}: {gain}");
    }
}
