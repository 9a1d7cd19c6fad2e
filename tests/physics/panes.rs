//! Lights without a surface behind panes and filters: closed forms, and the same light whatever the settings.

use glam::{DAffine3, DVec3, Vec3};
use photosite::integrator::RenderSettings;
use photosite::light::PointLight;
use photosite::optics::{Focus, LensDescription, LensKind, PixelGrid};
use photosite::scene::description::{
    AlphaMode, Colour, Dielectric, Diffuse, EmissionDescription, LayeredDescription, LightDescription, LightKind,
    MaterialModel, Roughness, TexturedFactor, ThinDielectric,
};
use photosite::spectrum::{Dispersion, Spectrum};

use crate::light_paths::{compare, gold, grey, lens, room};
use crate::stage::{Stage, camera, irradiance, mean, square};

fn lamp(position: DVec3) -> LightDescription {
    LightDescription {
        name: "lamp".into(),
        to_world: DAffine3::from_translation(position),
        later: vec![],
        kind: LightKind::Point(PointLight),
        emission: EmissionDescription { colour: Colour::Spectrum(Spectrum::constant(1.0)), level: None, texture: None },
    }
}

fn pane(transmittance: f32) -> MaterialModel {
    let (index, transmittance) = (Dispersion::constant(1.5), Spectrum::constant(transmittance));
    MaterialModel::ThinDielectric(ThinDielectric { index, transmittance })
}

/// glTF's clear material of a colour, thin or with a volume of some index behind that absorbs, m⁻¹.
fn clear(colour: f32, volume: Option<(f64, f32)>) -> MaterialModel {
    let (index, absorption) = volume.unwrap_or((1.5, 0.0));
    MaterialModel::Layered(Box::new(LayeredDescription {
        base_colour: grey(colour),
        roughness: TexturedFactor::plain(0.0),
        transmission: TexturedFactor::plain(1.0),
        index: Dispersion::constant(index),
        absorption_per_m: volume.map(|_| Spectrum::constant(absorption)),
        ..LayeredDescription::default()
    }))
}

/// Glass of an index and a roughness on the side that the normal points away from.
fn solid(index: f64, roughness: f32) -> MaterialModel {
    let (index, distribution) = (Dispersion::constant(index), Roughness::isotropic(roughness));
    MaterialModel::Dielectric(Dielectric { index, distribution, energy_compensation: false })
}

/// A square of 6 m across the light, its front up or down.
fn sheet(z: f32, up: bool) -> Vec<[Vec3; 3]> {
    square(Vec3::new(0.0, 0.0, z), Vec3::X, if up { Vec3::Y } else { Vec3::NEG_Y }, 3.0)
}

/// A floor 1 m below the camera, 3 m below the lamp: what of its light is left by the surfaces that `between` adds.
fn left(between: impl Fn(Stage) -> Stage) -> f64 {
    let settings = RenderSettings { samples_per_pixel: 4096, max_depth: 2, ..RenderSettings::default() };
    let seen = |stage: Stage| {
        // ±1 mrad along the normal.
        let lens = LensDescription { kind: LensKind::Pinhole, ..LensDescription::thin(0.1, 4.0, Focus::Infinity) };
        let grid = PixelGrid { resolution: [2, 2], pitch_m: [1e-4; 2] };
        mean(&irradiance(&stage.build(), &camera(&lens, &grid, DAffine3::IDENTITY), [2, 2], &settings))
    };
    let open = || Stage::default().diffuse(sheet(-1.0, true), 0.7, 0.0).light(lamp(DVec3::new(0.0, 0.0, 2.0)));
    seen(between(open())) / seen(open())
}

#[test]
fn panes_and_filters_leave_what_closed_forms_say() {
    // A pane of R = 0.04 twice, along the normal: (1 − R)/(1 + R).
    let clear_pane = 0.96 / 1.04;
    let up = |d: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, d));
    let filter = |stage: Stage, bottom: Option<f32>, top: Option<f32>| {
        let face = |stage: Stage, z: Option<f32>, is_top| match z {
            Some(z) => stage.mesh(sheet(z, is_top), clear(1.0, Some((1.0, 2.0))), None),
            None => stage,
        };
        face(face(stage, bottom, false), top, true)
    };
    // Rounding; and where holes are drawn, 5 σ = 5·(1 − T)·√(0.3·0.7/16384).
    const ROUNDING: f64 = 1e-4;
    let holes = 5.0 * (1.0 - clear_pane) * (0.21f64 / 16384.0).sqrt();
    let cases = [
        ("pane", left(|s| s.mesh(sheet(0.5, true), pane(1.0), None)), clear_pane, ROUNDING),
        ("pane from behind", left(|s| s.mesh(sheet(0.5, false), pane(1.0), None)), clear_pane, ROUNDING),
        ("coloured glTF pane", left(|s| s.mesh(sheet(0.5, true), clear(0.4, None), None)), 0.96 * 0.4, ROUNDING),
        (
            "two instances",
            left(|s| s.mesh(sheet(0.2, true), pane(1.0), None).again(up(0.5)).again(up(1.0))),
            clear_pane.powi(3),
            ROUNDING,
        ),
        (
            "half a pane",
            left(|s| s.mesh(sheet(0.5, true), pane(1.0), None).alpha(AlphaMode::Blend, 0.3)),
            0.3 * clear_pane + 0.7,
            holes + ROUNDING,
        ),
        (
            "a pane before a wall",
            left(|s| s.mesh(sheet(0.5, true), pane(1.0), None).diffuse(sheet(1.0, true), 0.5, 0.0)),
            0.0,
            0.0,
        ),
        ("solid glass", left(|s| s.mesh(sheet(0.5, true), clear(1.0, Some((1.5, 0.0))), None)), 0.0, 0.0),
        ("glass of index 1", left(|s| s.mesh(sheet(0.5, true), solid(1.0, 0.0), None)), 1.0, ROUNDING),
        ("matt glass of index 1", left(|s| s.mesh(sheet(0.5, false), solid(1.0, 0.5), None)), 1.0, ROUNDING),
        ("glass of index 1.5", left(|s| s.mesh(sheet(0.5, true), solid(1.5, 0.0), None)), 0.0, 0.0),
        ("filter", left(|s| filter(s, Some(0.25), Some(0.75))), (-2.0f64 * 0.5).exp(), ROUNDING),
        ("floor in the filter", left(|s| filter(s, None, Some(0.5))), (-2.0f64 * 1.5).exp(), ROUNDING),
        ("lamp in the filter", left(|s| filter(s, Some(0.5), Some(3.0))), (-2.0f64 * 1.5).exp(), ROUNDING),
        (
            "pane in the filter",
            left(|s| filter(s, Some(0.25), Some(0.75)).mesh(sheet(0.5, true), pane(0.5), None)),
            (-2.0f64 * 0.5).exp() * 0.96f64.powi(2) * 0.5 / (1.0 - 0.02f64.powi(2)),
            ROUNDING,
        ),
    ];
    for (name, found, expected, tolerance) in cases {
        assert!((found - expected).abs() <= tolerance, "{name}: {found} is not {expected}");
    }
}

#[test]
fn light_behind_panes_is_the_same_whatever_the_settings() {
    let diffuse = MaterialModel::Diffuse(Diffuse { reflectance: grey(0.7) });
    let above = || square(Vec3::new(0.1, 1.1, -0.3), Vec3::X, Vec3::Z, 0.6);
    for (name, settings) in [
        ("light paths", RenderSettings { light_paths: Some(1.0), ..RenderSettings::default() }),
        ("splitting", RenderSettings { splitting: Some(3), ..RenderSettings::default() }),
    ] {
        for (material, ball) in [("diffuse", diffuse.clone()), ("gold", gold(0.1))] {
            let stage = room(ball).mesh(above(), clear(0.5, None), None).light(lamp(DVec3::new(0.3, 1.5, 0.2)));
            compare(&format!("{name}, {material}"), &stage.build(), &lens(), settings.clone());
        }
    }
}
