//! From light to electrons, through lens and sensor together, against figures computed by hand.

use std::ops::ControlFlow;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use photosite::film::{FilmResponses, Response};
use photosite::integrator::{RenderJob, RenderSettings, render};
use photosite::light::PointLight;
use photosite::optics::{Focus, Intrinsics, LensDescription, PixelGrid};
use photosite::scene::Scene;
use photosite::scene::description::{Colour, EmissionDescription, LightDescription, LightKind};
use photosite::sensor::{SensorModel, presets};
use photosite::spectrum::{Spectrum, illuminant};

use crate::lens::disk_irradiance;
use crate::stage::{Stage, camera, square};

/// Electrons per second in every channel of a one-pixel sensor.
fn electron_rates(
    scene: &Scene,
    sensor: &SensorModel,
    lens: &LensDescription,
    to_world: DAffine3,
    samples: u32,
) -> Vec<(String, f64)> {
    let responses: Vec<_> =
        sensor.responses().into_iter().map(|(name, spectrum)| Response::new(name, spectrum)).collect();
    let grid = PixelGrid { resolution: [1, 1], pitch_m: sensor.pixel_pitch_m };
    let camera = camera(lens, &grid, to_world);
    let settings = RenderSettings { samples_per_pixel: samples, ..Default::default() };
    let clear = Spectrum::constant(1.0);
    let job = RenderJob {
        scene,
        camera: &camera,
        transmittance: &clear,
        responses: &responses,
        filters: None,
        importance: None,
        resolution: [1, 1],
        settings: &settings,
        device: None,
    };
    let film = render(&job, FilmResponses::new(&responses), &|_| ControlFlow::Continue(()));
    let estimate = film.estimate(responses.iter().map(|r| r.name.as_str()));
    estimate.mean.channels().iter().map(|c| (c.name.clone(), f64::from(c.data[0]))).collect()
}

#[test]
fn a_uniform_sky_frees_the_electrons_of_the_exact_aperture_integral() {
    let sky = illuminant::d65().scale(1e-3);
    let scene = Stage::default().sky(sky.clone()).build();
    for name in ["generic-cmos-color", "sony-imx249-mono"] {
        let sensor = presets::model(name).expect("a preset");
        for f_number in [16.0, 4.0, 1.4] {
            for degrees in [0.0f64, 35.0] {
                let mut lens = LensDescription::thin(0.016, f_number, Focus::Infinity);
                let tangent = degrees.to_radians().tan();
                let per_metre = 1.0 / sensor.pixel_pitch_m[0];
                let fx = 0.016 * per_metre;
                lens.intrinsics = Some(Intrinsics { fx, fy: fx, cx: 0.5 - tangent * fx, cy: 0.5, skew: 0.0 });
                let rates = electron_rates(&scene, &sensor, &lens, DAffine3::IDENTITY, 1 << 15);
                let geometric = disk_irradiance(0.5 / f_number, tangent);
                for ((channel, got), (_, response)) in rates.iter().zip(sensor.responses()) {
                    let expected = response.product(&sky).integral() * geometric;
                    // The bounds. 2¹⁵ stratified samples of four wavelengths leave less than 0.1 %.
                    let tolerance = if degrees == 0.0 { 0.002 } else { 0.005 };
                    let what = format!("{name} {channel}, f/{f_number}, {degrees}°: {got} e⁻/s, not {expected}");
                    assert!((got / expected - 1.0).abs() < tolerance, "{what}");
                }
            }
        }
    }
}

#[test]
fn a_known_lamp_on_a_known_patch_frees_the_electrons_computed_by_hand() {
    // A lamp of 2 W/sr in a line at 550 nm, 2 m above a patch of reflectance 0.5: 0.5 W/m², radiance 0.25/π W/m²/sr.
    let line = Spectrum::from_fn(|l| if l == 550.0 { 2.0 } else { 0.0 });
    let lamp = LightDescription {
        name: "lamp".into(),
        to_world: DAffine3::from_translation(DVec3::Y * 2.0),
        later: Vec::new(),
        kind: LightKind::Point(PointLight),
        emission: EmissionDescription { colour: Colour::Spectrum(line), level: None, texture: None },
    };
    let patch = square(Vec3::ZERO, Vec3::X, Vec3::NEG_Z, 0.05);
    let scene = Stage::default().diffuse(patch, 0.5, 0.0).light(lamp).build();
    // Seen from 1 m above, beside the lamp's line, through 16 mm at f/4 focused on it: v = 1/(1/0.016 − 1/1).
    let down = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let to_world = DAffine3::from_rotation_translation(down, DVec3::Y);
    let lens = LensDescription::thin(0.016, 4.0, Focus::Distance(1.0));
    let sensor = presets::model("sony-imx249-mono").expect("a preset");
    let rates = electron_rates(&scene, &sensor, &lens, to_world, 1 << 14);

    let v = 1.0 / (1.0 / 0.016 - 1.0);
    let radiance = 0.25 / std::f64::consts::PI;
    let half_aperture: f64 = 0.016 / 4.0 / 2.0;
    let irradiance = std::f64::consts::PI * radiance * half_aperture.powi(2) / (half_aperture.powi(2) + v * v);
    // One photon of 550 nm carries 6.62607015e-34 · 299792458 / 550e-9 = 3.611720e-19 J; the pixel is 5.86 µm square.
    let photons = irradiance * 5.86e-6 * 5.86e-6 / 3.611_720e-19;
    let expected = photons * f64::from(sensor.quantum_efficiency[0].eval(550.0)) * sensor.fill_factor;
    let (channel, got) = &rates[0];
    // A line 2 nm wide at its foot is drawn with a piecewise constant density, which leaves ±0.5 relative a sample of
    // four wavelengths: 0.5/√(4 · 2¹⁴) = 0.2 %, far less with stratification.
    assert!((got / expected - 1.0).abs() < 0.005, "{channel}: {got} e⁻/s, not {expected}");
}
