//! Grey stays grey: an even surface in any light, exposed with all noise and developed, has no colour.

use photosite::colour::{ColourSpace, cielab, difference};
use photosite::develop::colour_matrix::camera_colour;
use photosite::develop::{DevelopSettings, WhiteBalance, develop_linear};
use photosite::image::Planes;
use photosite::raw::RawImage;
use photosite::sensor::{NoiseKey, SensorModel, Stages, expose, presets};
use photosite::spectrum::{Spectrum, illuminant};

use glam::DVec3;

use crate::sensor_cases::EXPOSURE;

const SIDE: usize = 96;

/// A grey wall at 40 % of saturation.
fn photograph(sensor: &SensorModel, light: &Spectrum, seed: u64) -> RawImage {
    let responses = sensor.responses();
    let electrons: Vec<f64> = responses.iter().map(|(_, r)| r.product(light).integral()).collect();
    let scale = 0.4 * sensor.saturation_capacity(&EXPOSURE).0 / electrons.iter().copied().fold(0.0, f64::max);
    let mut planes = Planes::zeros(SIDE, SIDE, sensor.cfa.channels());
    for (channel, electrons) in planes.channels_mut().iter_mut().zip(electrons) {
        channel.data.fill((electrons * scale) as f32);
    }
    let mut raw = expose(&planes, sensor, &EXPOSURE, Stages::ALL, NoiseKey { seed, frame: 0 }).expect("valid");
    let colour = camera_colour(&responses, light).expect("distinct channels").expect("a colour sensor");
    raw.metadata.colour_matrix_d65 = Some(colour.matrix_d65);
    raw.metadata.colour_matrix_a = Some(colour.matrix_a);
    raw.metadata.as_shot_neutral = Some(colour.neutral);
    raw
}

#[test]
fn a_grey_wall_is_neutral_in_any_light_and_by_any_balance() {
    let sensor = presets::model("generic-cmos-color").expect("a preset");
    let white = ColourSpace::Srgb.white();
    for (seed, light) in ["A", "D50", "D65", "D75", "E", "FL2", "FL11", "LED-B1", "3000K", "10000K"].iter().enumerate()
    {
        let raw = photograph(&sensor, &illuminant::illuminant(light).expect("known"), seed as u64);
        for white_balance in [WhiteBalance::AsShot, WhiteBalance::GreyWorld] {
            let settings = DevelopSettings { white_balance, ..DevelopSettings::default() };
            let (picture, _) = develop_linear(&raw, &settings).expect("developed");
            let mean = |name: &str| {
                let plane = picture.plane(name).expect("a colour picture");
                plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64
            };
            let xyz = ColourSpace::Srgb.to_xyz() * DVec3::new(mean("R"), mean("G"), mean("B"));
            let lab = cielab::from_xyz(xyz, white);
            let grey = cielab::from_xyz(white * xyz.y, white);
            // Shot noise of 1 % a pixel leaves 0.02 % in the mean of a quarter of 9216 pixels, four times that through
            // the colour matrix in weak channels: ΔE00 below 0.1. The rest is the nonuniformity of pixels, 1 % each.
            let found = difference::delta_e_2000(grey, lab);
            println!("{light} {white_balance:?}: {found:.3}");
            assert!(found < 0.3, "{light} {white_balance:?}: ΔE00 {found}, {lab}");
        }
    }
}
