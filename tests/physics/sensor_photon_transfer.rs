//! The photon transfer curve: what the noise of flat images tells of a sensor must be what went in (EMVA 1288).

use photosite::math::statistics::Moments;
use photosite::sensor::{FixedPattern, NoiseKey, SensorModel, Stages, expose};
use photosite::units::{Decibels, Electrons};

use crate::sensor_cases::{EXPOSURE, flat, quiet_sensor};

const SIDE: usize = 256;
const PIXELS: f64 = (SIDE * SIDE) as f64;

/// Mean and temporal variance of the digital numbers at a light level, from two images of it: fixed patterns drop out
/// of their difference, σ² = ½·Var(a − b).
fn mean_and_temporal_variance(sensor: &SensorModel, mean_e: f32, gain_db: f64, seed: u64) -> (f64, f64) {
    let exposure = photosite::sensor::Exposure { gain: Decibels(gain_db), ..EXPOSURE };
    let light = flat(sensor, SIDE, SIDE, mean_e);
    let image =
        |frame| expose(&light, sensor, &exposure, Stages::ALL, NoiseKey { seed, frame }).expect("valid exposure").data;
    let (a, b) = (image(0), image(1));
    let mean: Moments = a.iter().chain(&b).map(|&dn| f64::from(dn)).collect();
    let difference: Moments = a.iter().zip(&b).map(|(&a, &b)| f64::from(a) - f64::from(b)).collect();
    (mean.mean(), difference.variance() / 2.0)
}

#[test]
fn variance_over_mean_is_the_system_gain() {
    for (gain_db, system_gain) in [(0.0, 0.25), (12.0, 0.25 * 10f64.powf(0.6))] {
        let mut sensor = quiet_sensor();
        sensor.noise.read_out.change(|noise| noise.read = Electrons(5.0));
        sensor.noise.dark_current_e_per_s = 30.0;
        sensor.noise.prnu = FixedPattern::of_pixels(0.01);
        sensor.noise.read_out.change(|noise| noise.dsnu = FixedPattern::of_pixels(3.0));
        sensor.converter.conversion_gain_dn_per_e = 0.25;
        let (dark_mean, dark_variance) = mean_and_temporal_variance(&sensor, 0.0, gain_db, 1);
        // A line through the origin: slope = Σ x·v / Σ x². The sample variance of N differences has the standard
        // deviation v·√(2/N); the dark frame's own error is much smaller and covered by the 5 σ.
        let (mut xv, mut xx, mut spread) = (0.0, 0.0, 0.0);
        for step in 1..=10u8 {
            let (mean, variance) =
                mean_and_temporal_variance(&sensor, 2500.0 * f32::from(step), gain_db, u64::from(step));
            let (x, v) = (mean - dark_mean, variance - dark_variance);
            xv += x * v;
            xx += x * x;
            spread += (x * variance * (2.0 / PIXELS).sqrt()).powi(2);
        }
        let (slope, tolerance) = (xv / xx, 5.0 * spread.sqrt() / xx);
        assert!((slope - system_gain).abs() < tolerance, "{slope} for {system_gain} ± {tolerance}");
        // Less than 1.5 % of play, so that the test says something.
        assert!(tolerance < 0.015 * system_gain);
    }
}

#[test]
fn noise_is_what_the_model_foretells() {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.read = Electrons(3.0));
    sensor.noise.dark_current_e_per_s = 12.0;
    sensor.noise.prnu = FixedPattern::of_pixels(0.02);
    sensor.noise.read_out.change(|noise| noise.dsnu = FixedPattern::of_pixels(4.0));
    for mean_e in [0.0, 10.0, 1000.0, 40_000.0] {
        let (mean, variance) = mean_and_temporal_variance(&sensor, mean_e, 0.0, 7);
        let predicted = sensor.noise_variance(Electrons(f64::from(mean_e)), &EXPOSURE);
        // √(2/N) for Gaussian noise, a little more for the Poisson part; 5 σ. The mean is off by the patterns' σ/√N.
        assert!((variance / predicted - 1.0).abs() < 5.0 * (2.2 / PIXELS).sqrt(), "{variance} for {predicted}");
        let spatial = (0.02 * f64::from(mean_e)).powi(2) + 16.0;
        let expected = 1000.0 + f64::from(mean_e) + 12.0;
        assert!((mean - expected).abs() < 5.0 * ((spatial + predicted) / PIXELS).sqrt(), "{mean} for {expected}");
    }
}

#[test]
fn a_raw_file_tells_the_same_noise() {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.read = Electrons(3.0));
    sensor.noise.dark_current_e_per_s = 12.0;
    sensor.converter.conversion_gain_dn_per_e = 0.5;
    let raw = expose(&flat(&sensor, 1, 1, 0.0), &sensor, &EXPOSURE, Stages::ALL, NoiseKey::default()).expect("valid");
    let range = f64::from(raw.white_level_dn) - f64::from(raw.black_level_dn.mean());
    let [slope, offset] = raw.metadata.noise_profile[0];
    for mean_e in [0.0, 500.0, 20_000.0] {
        // x = K·μ/range, Var(x) = K²·σ²/range².
        let predicted = sensor.noise_variance(Electrons(mean_e), &EXPOSURE) * 0.25 / (range * range);
        let stated = slope * (0.5 * mean_e / range) + offset;
        assert!((stated / predicted - 1.0).abs() < 1e-12, "{stated} for {predicted}");
    }
}

#[test]
fn quantisation_variance_is_a_twelfth() {
    let sensor = quiet_sensor();
    // A ramp over 100 DN in steps of 100/N, an irrational-looking part of a DN, without any noise.
    let mut light = flat(&sensor, SIDE, SIDE, 0.0);
    let level = |i: usize| (200.0 + 100.0 * (i as f64 + 0.5) / PIXELS) as f32;
    for (i, e) in light.channels_mut()[0].data.iter_mut().enumerate() {
        *e = level(i);
    }
    let raw = expose(&light, &sensor, &EXPOSURE, Stages::NONE, NoiseKey::default()).expect("valid exposure");
    let error: Moments =
        raw.data.iter().enumerate().map(|(i, &dn)| f64::from(dn) - 1000.0 - f64::from(level(i))).collect();
    // Each DN is crossed in 655 or 656 steps: the discretisation of the uniform error is of order 1/655² of 1/12, and
    // f32 rounds levels to 1.5e-5 DN.
    assert!((error.variance() - 1.0 / 12.0).abs() < 1e-5, "{}", error.variance());
    assert!(error.mean().abs() < 1e-4, "{}", error.mean());
}
