//! Grey stays grey: an even surface in any light, exposed with all noise and developed, has no colour.

use photosite::colour::{ColourSpace, cielab, difference};
use photosite::develop::colour_matrix::camera_colour;
use photosite::develop::{DevelopSettings, Development, WhiteBalance, develop_linear};
use photosite::image::Planes;
use photosite::raw::RawImage;
use photosite::sensor::{NoiseKey, SensorModel, Stages, expose, presets};
use photosite::spectrum::{Spectrum, illuminant};

use glam::DVec3;

use crate::sensor_cases::EXPOSURE;

const SIDE: usize = 96;

/// A grey wall at 40 % of saturation.
fn photograph(sensor: &SensorModel, light: &Spectrum, stages: Stages, seed: u64) -> RawImage {
    let responses = sensor.responses();
    let electrons: Vec<f64> = responses.iter().map(|(_, r)| r.product(light).integral()).collect();
    let scale = 0.4 * sensor.saturation_capacity(&EXPOSURE).0 / electrons.iter().copied().fold(0.0, f64::max);
    let mut planes = Planes::zeros(SIDE, SIDE, sensor.cfa.channels());
    for (channel, electrons) in planes.channels_mut().iter_mut().zip(electrons) {
        channel.data.fill((electrons * scale) as f32);
    }
    let mut raw = expose(&planes, sensor, &EXPOSURE, stages, NoiseKey { seed, frame: 0 }).expect("valid");
    let colour = camera_colour(&responses, light).expect("distinct channels").expect("a colour sensor");
    raw.metadata.colour_matrix_d65 = Some(colour.matrix_d65);
    raw.metadata.colour_matrix_a = Some(colour.matrix_a);
    raw.metadata.as_shot_neutral = Some(colour.neutral);
    raw
}

/// How far the mean colour of the developed wall is from grey, ΔE₀₀.
fn distance_from_grey(raw: &RawImage, settings: &DevelopSettings) -> (f64, Development) {
    let (picture, development) = develop_linear(raw, settings).expect("developed");
    let mean = |name: &str| {
        let plane = picture.plane(name).expect("a colour picture");
        plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64
    };
    let white = ColourSpace::Srgb.white();
    let xyz = ColourSpace::Srgb.to_xyz() * DVec3::new(mean("R"), mean("G"), mean("B"));
    let grey = cielab::from_xyz(white * xyz.y, white);
    (difference::delta_e_2000(grey, cielab::from_xyz(xyz, white)), development)
}

#[test]
fn a_grey_wall_is_neutral_in_any_light_and_by_any_balance() {
    let sensor = presets::model("generic-cmos-color").expect("a preset");
    for (seed, light) in ["A", "D50", "D65", "D75", "E", "FL2", "FL11", "LED-B1", "3000K", "10000K"].iter().enumerate()
    {
        let light_spectrum = illuminant::illuminant(light).expect("known");
        let raw = photograph(&sensor, &light_spectrum, Stages::ALL, seed as u64);
        let as_shot = DevelopSettings::default();
        let (_, development) = distance_from_grey(&raw, &as_shot);
        let patch_px = Some([20, 30, 60, 50]);
        for settings in [
            as_shot.clone(),
            DevelopSettings { white_balance: WhiteBalance::GreyWorld, ..as_shot.clone() },
            DevelopSettings { white_balance: WhiteBalance::Patch, patch_px, ..as_shot.clone() },
            // What the picture says of its light, given back.
            DevelopSettings {
                white_balance: WhiteBalance::Temperature,
                temperature_k: development.temperature_k,
                tint: development.tint,
                ..as_shot.clone()
            },
        ] {
            // Shot noise of 1 % a pixel leaves 0.02 % in the mean of a quarter of 9216 pixels, four times that through
            // the colour matrix in weak channels: ΔE00 below 0.1. The rest is the nonuniformity of pixels, 1 % each.
            let (found, _) = distance_from_grey(&raw, &settings);
            println!("{light} {:?}: {found:.3}", settings.white_balance);
            assert!(found < 0.3, "{light} {:?}: ΔE00 {found}", settings.white_balance);
        }
        // The brightest pixels of a noisy wall are those with the most noise, which differs from channel to channel.
        let even = photograph(&sensor, &light_spectrum, Stages::NONE, 0);
        let settings = DevelopSettings { white_balance: WhiteBalance::WhitePatch, ..as_shot.clone() };
        // It looks for a level among 4096: half a step is 0.03 % of the most sensitive channel, 0.3 % of one that sees a
        // tenth of the light.
        let (found, _) = distance_from_grey(&even, &settings);
        println!("{light} white patch: {found:.3}");
        assert!(found < 0.3, "{light} white patch: ΔE00 {found}");
    }
}

#[test]
fn no_balance_leaves_the_colour_of_the_light() {
    let sensor = presets::model("generic-cmos-color").expect("a preset");
    let raw = photograph(&sensor, &illuminant::a(), Stages::NONE, 0);
    let settings = DevelopSettings { white_balance: WhiteBalance::None, ..DevelopSettings::default() };
    assert!(distance_from_grey(&raw, &settings).0 > 10.0);
}
