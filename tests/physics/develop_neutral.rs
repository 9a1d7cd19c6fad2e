//! Grey stays grey: an even surface in any light, exposed with all noise and developed, has no colour.

use photosite::colour::{ColourSpace, cielab, difference};
use photosite::develop::camera_colour::camera_colour;
use photosite::develop::{DevelopSettings, Development, WhiteBalance, develop_linear};
use photosite::image::Planes;
use photosite::raw::{Cfa, RawImage};
use photosite::sensor::{Exposure, NoiseKey, SensorModel, Stages, expose, presets};
use photosite::spectrum::{Spectrum, illuminant};
use photosite::units::Seconds;

use glam::DVec3;
use rstest::rstest;

const SIDE: usize = 384;
/// Short: dark current adds the same to all channels, which is most to weak ones, and nothing in a raw file tells of
/// it.
const EXPOSURE: Exposure = Exposure::of(Seconds(0.01));

/// A sensor with these filters over its pixels. Clear ones see what the bare silicon of a monochrome sensor does.
fn sensor(cfa: &str) -> SensorModel {
    let mut sensor = presets::model("generic-cmos-color").expect("a preset");
    let of_silicon = presets::model("sony-imx249-mono").expect("a preset").quantum_efficiency[0].clone();
    let cfa = Cfa::parse(cfa).expect("known");
    let efficiency = |name: &String| match sensor.cfa.channels().iter().position(|own| own == name) {
        Some(own) => sensor.quantum_efficiency[own].clone(),
        None => of_silicon.clone(),
    };
    sensor.quantum_efficiency = cfa.channels().iter().map(efficiency).collect();
    sensor.cfa = cfa;
    sensor
}

/// A grey wall at 40 % of saturation, in its middle a sheet of white paper, half of whose left side is blown out.
fn photograph(sensor: &SensorModel, light: &Spectrum, stages: Stages, seed: u64) -> RawImage {
    let responses = sensor.responses();
    let electrons: Vec<f64> = responses.iter().map(|(_, r)| r.product(light).integral()).collect();
    let scale = 0.4 * sensor.saturation_capacity(&EXPOSURE).0 / electrons.iter().copied().fold(0.0, f64::max);
    let mut planes = Planes::zeros(SIDE, SIDE, sensor.cfa.channels());
    for (channel, electrons) in planes.channels_mut().iter_mut().zip(electrons) {
        for (i, value) in channel.data.iter_mut().enumerate() {
            *value = (electrons * scale * brightness(i % SIDE, i / SIDE)) as f32;
        }
    }
    let mut raw = expose(&planes, sensor, &EXPOSURE, stages, NoiseKey { seed, frame: 0 }).expect("valid");
    let colour = camera_colour(&responses, light).expect("distinct channels").expect("a colour sensor");
    colour.write_to(&mut raw.metadata);
    raw
}

/// Brightness of the wall: 1.
fn brightness(x: usize, y: usize) -> f64 {
    // No tile lies half on the paper.
    let paper = 120..264;
    if !(paper.contains(&x) && paper.contains(&y)) {
        1.0
    } else if x < 144 {
        // One channel is full, and others not.
        3.2
    } else {
        1.9
    }
}

/// How far the mean colour of the developed wall is from grey, ΔE₀₀.
fn distance_from_grey(raw: &RawImage, settings: &DevelopSettings) -> (f64, Development) {
    let (image, development) = develop_linear(raw, settings).expect("developed");
    // Away from the paper, and from what demosaicking spreads of it.
    let of_wall = |i: &usize| i % SIDE < 96 || i % SIDE > 287 || i / SIDE < 96 || i / SIDE > 287;
    let pixels: Vec<usize> = (0..SIDE * SIDE).filter(of_wall).collect();
    let mean = |name: &str| {
        let plane = image.plane(name).expect("a colour image");
        pixels.iter().map(|&i| f64::from(plane[i])).sum::<f64>() / pixels.len() as f64
    };
    let white = ColourSpace::Srgb.white();
    let xyz = ColourSpace::Srgb.to_xyz() * DVec3::new(mean("R"), mean("G"), mean("B"));
    let grey = cielab::from_xyz(white * xyz.y, white);
    (difference::delta_e_2000(grey, cielab::from_xyz(xyz, white)), development)
}

#[rstest]
#[case::bayer("GBRG", &["A", "D50", "D65", "D75", "E", "FL2", "FL11", "LED-B1", "3000K", "10000K"])]
#[case::x_trans("x-trans", &["A", "D65", "FL11"])]
#[case::quad_bayer("quad-bayer", &["A", "D65", "FL11"])]
#[case::three_chips("full:RGB", &["A", "D65", "FL11"])]
#[case::clear("rgbw", &["A", "D50", "D65", "FL11"])]
fn a_grey_wall_is_neutral_in_any_light_and_by_any_balance(#[case] cfa: &str, #[case] lights: &[&str]) {
    let sensor = sensor(cfa);
    for (seed, light) in lights.iter().enumerate() {
        let light_spectrum = illuminant::illuminant(light).expect("known");
        let raw = photograph(&sensor, &light_spectrum, Stages::ALL, seed as u64);
        let as_shot = DevelopSettings::default();
        let (_, development) = distance_from_grey(&raw, &as_shot);
        for (settings, limit) in [
            (as_shot.clone(), 0.3),
            (DevelopSettings { white_balance: WhiteBalance::GreyWorld, ..as_shot.clone() }, 0.3),
            (DevelopSettings { white_balance: WhiteBalance::WhitePatch, ..as_shot.clone() }, 0.3),
            // Of the wall and of the paper, its blown part included.
            (balanced_by([8, 280, 240, 96], &as_shot), 0.3),
            (balanced_by([120, 120, 144, 144], &as_shot), 0.3),
            // What the image says of its light, given back.
            (
                DevelopSettings {
                    white_balance: WhiteBalance::Temperature,
                    temperature_k: development.temperature_k,
                    tint: development.tint,
                    ..as_shot.clone()
                },
                0.3,
            ),
        ] {
            // Beside clear pixels colours have few electrons: what noise makes the brightest patch moves its colour.
            // And the two numbers of a temperature cannot say the neutral of four channels in a light between those of
            // the matrices.
            if cfa == "rgbw" && matches!(settings.white_balance, WhiteBalance::WhitePatch | WhiteBalance::Temperature) {
                continue;
            }
            // Shot noise of 1 % a pixel leaves 0.03 % in the mean of a quarter of the pixels of a patch of 5760 or
            // more, four times that through the colour matrix in weak channels: ΔE00 below 0.1. The rest is the
            // nonuniformity of pixels, 1 % each.
            let (found, _) = distance_from_grey(&raw, &settings);
            println!("{cfa} {light} {:?} {:?}: {found:.3}", settings.white_balance, settings.patch_px);
            assert!(found < limit, "{cfa} {light} {:?} {:?}: ΔE00 {found}", settings.white_balance, settings.patch_px);
        }
    }
}

fn balanced_by(patch_px: [usize; 4], settings: &DevelopSettings) -> DevelopSettings {
    DevelopSettings { white_balance: WhiteBalance::Patch, patch_px: Some(patch_px), ..settings.clone() }
}

#[test]
fn no_balance_leaves_the_colour_of_the_light() {
    let sensor = presets::model("generic-cmos-color").expect("a preset");
    let raw = photograph(&sensor, &illuminant::a(), Stages::NONE, 0);
    let settings = DevelopSettings { white_balance: WhiteBalance::None, ..DevelopSettings::default() };
    let image = develop_linear(&raw, &settings).expect("developed").0;
    // That of a file which says that the light of the scene is the one to which all channels respond alike.
    let mut told = raw.clone();
    told.metadata.as_shot_neutral = Some(vec![1.0; 3]);
    assert!(image == develop_linear(&told, &DevelopSettings::default()).expect("developed").0);
    // Illuminant A has a tenth of the blue photons of an equal-energy light for its red ones: the wall is red, then
    // green.
    let mean = |name: &str| image.plane(name).expect("a plane").iter().map(|&v| f64::from(v)).sum::<f64>();
    assert!(mean("R") > mean("G") && mean("G") > mean("B"));
}
