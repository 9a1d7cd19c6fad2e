//! From light to electrons by hand, and to an exposure time.

use photosite::image::Planes;
use photosite::sensor::{AutoExposure, Exposure, NoiseKey, Stages, auto_exposure, expose, presets};
use photosite::spectrum::Spectrum;
use photosite::units::{Celsius, Decibels, Electrons, Seconds};

use crate::sensor_cases::{EXPOSURE, flat, quiet_sensor};

#[test]
fn electrons_of_a_known_lamp_on_a_known_patch_by_hand() {
    // A lamp of 2 W at 550 nm that shines evenly in all directions: I = 2/(4π) = 0.159154943 W/sr.
    // A patch 1.5 m away, facing it: E = I/1.5² = 0.0707355302 W/m². Diffuse, reflectance 0.4:
    // L = 0.4·E/π = 0.00900632744 W/m²/sr. A lens at f/4, focused far away, on its axis, small-aperture limit:
    // E' = π/4·L/16 = 4.42097064e-4 W/m². On 5 µm × 5 µm: 1.10524266e-14 W.
    // A photon of 550 nm carries 6.62607015e-34·299792458/550e-9 = 3.61171974e-19 J: 30601.5617 photons/s.
    // Half of them become electrons; in 20 ms that makes 306.015617 e⁻.
    let mut sensor = quiet_sensor();
    sensor.pixel_pitch_m = [5e-6, 5e-6];
    sensor.quantum_efficiency = vec![Spectrum::constant(0.5)];
    let lamp = Spectrum::from_fn(|lambda| if lambda == 550.0 { 2.0 } else { 0.0 });
    let geometry = 0.4 / (4.0 * std::f64::consts::PI * 1.5f64.powi(2)) / 16.0 / 4.0;
    let (_, response) = &sensor.responses()[0];
    let electrons = response.product(&lamp).integral() * geometry * 0.02;
    // Tables of f32: 2⁻²⁴ relative in each factor.
    assert!((electrons / 306.015_617 - 1.0).abs() < 1e-6, "{electrons}");
}

#[test]
fn auto_exposure_brings_the_bright_pixels_to_the_level() {
    for name in presets::names() {
        let sensor = presets::model(name).expect("listed");
        // A ramp of rates, and one pixel in 400 that shines far brighter.
        let (width, height) = (100, 80);
        let mut rates = Planes::zeros(width, height, sensor.cfa.channels());
        for channel in rates.channels_mut() {
            for (i, rate) in channel.data.iter_mut().enumerate() {
                *rate = if i % 400 == 0 { 1e9 } else { 10.0 * i as f32 };
            }
        }
        let target = AutoExposure { brighter_part: 0.01, level: 0.8 };
        let [least, most] = sensor.converter.gain_range;
        let (gain, temperature) = (Decibels(6.0f64.clamp(least.0, most.0)), Celsius(25.0));
        let time = auto_exposure(&rates, Seconds(1.0), &sensor, gain, temperature, target).expect("there is light");
        let exposure = Exposure { time, gain, temperature, frame_interval: None };
        let raw = expose(&rates.scaled(time.0), &sensor, &exposure, Stages::NONE, NoiseKey::default()).expect("valid");
        let numbers = raw.cropped().data;
        let saturation = sensor.saturation_capacity(&exposure).0 * sensor.converter.system_gain(gain);
        let level = f64::from(raw.black_level_dn.mean()) + 0.8 * saturation;
        // The dark current, which is left out here, is less than a DN of it.
        let brighter = numbers.iter().filter(|&&dn| f64::from(dn) > level + 1.0).count();
        let close = numbers.iter().filter(|&&dn| f64::from(dn) > level - 0.01 * saturation).count();
        assert!(brighter <= numbers.len() / 100, "{name}: {brighter} pixels above the level");
        assert!(close >= numbers.len() / 100, "{name}: {close} pixels at the level");
    }
}

#[test]
fn black_pictures_have_no_exposure_time() {
    let sensor = quiet_sensor();
    let target = AutoExposure::default();
    let gain = Decibels(0.0);
    for rates in [flat(&sensor, 8, 8, 0.0), flat(&sensor, 0, 0, 0.0)] {
        assert!(auto_exposure(&rates, Seconds(1.0), &sensor, gain, Celsius(25.0), target).is_err());
    }
    assert_eq!(sensor.saturation_capacity(&EXPOSURE), Electrons(60_000.0));
}
