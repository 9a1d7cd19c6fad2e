//! Brackets of the real sensor chain, merged.

use photosite::develop::merge::merge;
use photosite::math::statistics::Moments;
use photosite::raw::RawImage;
use photosite::sensor::{Exposure, NoiseKey, SensorModel, Stages, expose, presets};
use photosite::units::{Electrons, Seconds};

use crate::sensor_cases::{EXPOSURE, flat};

const SIDE: usize = 128;

/// Images of even light, one for each time, each with noise of its own.
fn bracket(sensor: &SensorModel, rate_e_per_s: f64, times: &[f64]) -> Vec<RawImage> {
    let shoot = |(frame, &time): (usize, &f64)| {
        let exposure = Exposure { time: Seconds(time), ..EXPOSURE };
        let light = flat(sensor, SIDE, SIDE, (rate_e_per_s * time) as f32);
        let key = NoiseKey { seed: 11, frame: frame as u64 };
        expose(&light, sensor, &exposure, Stages::ALL, key).expect("valid")
    };
    times.iter().enumerate().map(shoot).collect()
}

/// Times two stops apart, from 0.1 ms on.
fn times() -> Vec<f64> {
    (0..7).map(|i| 1e-4 * 4f64.powi(i)).collect()
}

#[test]
fn radiance_is_recovered_within_1_percent_over_100_db() {
    for name in ["sony-imx249-mono", "sony-imx249-color", "automotive-hdr-color"] {
        let sensor = presets::model(name).expect("a preset");
        let times = times();
        let capacity = sensor.saturation_capacity(&EXPOSURE).0;
        // The brightest patch reaches 80 % of saturation in the shortest time, the darkest is 100 dB below, a factor of
        // 10⁵; in between steps of 5 dB, and some close to where one of the times saturates.
        let brightest = 0.8 * capacity / times[0];
        let even = (0..=20).map(|step| brightest * 10f64.powf(-f64::from(step) / 4.0));
        let critical = times[1..6].iter().flat_map(|time| [0.95, 0.97, 0.99].map(|part| part * capacity / time));
        for rate in even.chain(critical) {
            let merged = merge(&bracket(&sensor, rate, &times)).expect("a bracket");
            let per_signal = capacity / times[0];
            let found: Moments = merged.signal.iter().map(|&x| f64::from(x) * per_signal).collect();
            // Dark current is light to the camera.
            let truth = rate + sensor.noise.dark_current(EXPOSURE.temperature);
            let error = found.mean() / truth - 1.0;
            assert!(error.abs() < 0.01, "{name}: {} e⁻/s for {truth}, {:.2} % off", found.mean(), 100.0 * error);
            assert_eq!(merged.saturated, 0, "{name} at {rate}");
        }
    }
}

#[test]
fn the_noise_of_a_merged_bracket_is_the_least_there_can_be() {
    let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
    sensor.noise.prnu = Default::default();
    sensor.noise.read_out.change(|noise| noise.dsnu = Default::default());
    let times = times();
    let capacity = sensor.saturation_capacity(&EXPOSURE).0;
    for rate in [3.0, 30.0, 1e3, 1e5, 2e7] {
        let merged = merge(&bracket(&sensor, rate, &times)).expect("a bracket");
        let found: Moments = merged.signal.iter().map(|&x| f64::from(x) * capacity / times[0]).collect();
        // The Cramér–Rao bound of Gaussian noise with known variances: 1/Σ t²/v over the images that are not
        // saturated.
        let information = |&time: &f64| {
            let exposure = Exposure { time: Seconds(time), ..EXPOSURE };
            time * time / sensor.noise_variance(Electrons(rate * time), &exposure)
        };
        let bound = 1.0 / times.iter().filter(|time| rate * **time < 0.95 * capacity).map(information).sum::<f64>();
        // A variance of 16 384 pixels: 5 σ are 5.5 %. Weights are estimated from the same data; what that costs is of
        // second order in the noise of the estimate.
        let ratio = found.variance() / bound;
        assert!((ratio - 1.0).abs() < 0.055, "{ratio} at {rate} e⁻/s");
        // And without bias: 5 σ of the mean.
        let dark = sensor.noise.dark_current(EXPOSURE.temperature);
        let spread = 5.0 * (bound / (SIDE * SIDE) as f64).sqrt() + 1e-4 * rate;
        assert!((found.mean() - rate - dark).abs() < spread, "{} for {rate} + {dark}", found.mean());
    }
}

#[test]
fn two_exposures_take_a_sensor_for_cars_to_128_db() {
    // Its 88 dB and a hundredth of the time, as its small photodiodes would take a hundredth of the light.
    let sensor = presets::model("automotive-hdr-color").expect("a preset");
    let times = [1e-4, 1e-2];
    let dark = |first_frame: u64| {
        let images: Vec<RawImage> = (first_frame..)
            .zip(times)
            .map(|(frame, time)| {
                let exposure = Exposure { time: Seconds(time), ..EXPOSURE };
                let key = NoiseKey { seed: 5, frame };
                expose(&flat(&sensor, SIDE, SIDE, 0.0), &sensor, &exposure, Stages::ALL, key).expect("valid")
            })
            .collect();
        merge(&images).expect("a bracket").signal
    };
    // What stays from image to image cancels.
    let difference: Moments = dark(0).iter().zip(dark(2)).map(|(a, b)| f64::from(a - b)).collect();
    let found_db = -20.0 * (difference.variance() / 2.0).sqrt().log10();
    let exposure = Exposure { time: Seconds(times[1]), ..EXPOSURE };
    let noise_e = sensor.noise_variance(Electrons(0.0), &exposure).sqrt();
    let formula_db = 20.0 * (sensor.saturation_capacity(&exposure).0 / noise_e * times[1] / times[0]).log10();
    // A variance of 16 384 pixels: 5 σ are 5.5 % or 0.24 dB of the noise; the short exposure adds 0.01 % of
    // information. The model counts 1/12 for numbers that merging need not round here: 2 % of the variance, 0.09 dB.
    assert!((found_db - formula_db).abs() < 0.24 + 0.09, "{found_db} dB for {formula_db} dB");
    assert!(found_db > 120.0, "{found_db} dB");
}
