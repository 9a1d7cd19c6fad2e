//! Sensors whose numbers are nonlinear on purpose, and the way back from them.

use photosite::image::{Channel, Planes};
use photosite::math::statistics::Moments;
use photosite::raw::{read_dng, write_dng};
use photosite::sensor::{
    Binning, Companding, CompandingCurve, Exposure, Logarithmic, NoiseKey, SensorModel, Stages, VideoCurve, expose,
    presets,
};
use photosite::units::{Decibels, Electrons, Seconds};

use crate::sensor_cases::{EXPOSURE, flat, quiet_sensor};

/// The curve of a sensor for cars, from 16 to 12 bits.
fn knees() -> Companding {
    let points = vec![[0, 0], [1500, 1500], [4000, 2000], [16_000, 2800], [65_535, 4095]];
    Companding { bits: 12, curve: CompandingCurve::KneePoints(points) }
}

fn companded(companding: Companding) -> SensorModel {
    let mut sensor = quiet_sensor();
    sensor.converter.companding = Some(companding);
    sensor
}

fn logarithmic() -> SensorModel {
    let mut sensor = quiet_sensor();
    sensor.logarithmic = Some(Logarithmic { reference_e_per_s: 1000.0 });
    sensor.converter.conversion_gain_dn_per_e = 10.0;
    sensor
}

fn curved(gamma: f64) -> SensorModel {
    let mut sensor = quiet_sensor();
    sensor.video.curve = Some(VideoCurve { gamma, range_dn: 64_535.0 });
    sensor
}

/// Charges from 1 to 50 000 e⁻ in equal ratios.
fn charges() -> Vec<f32> {
    (0..2000).map(|i| 50_000f32.powf(i as f32 / 1999.0)).collect()
}

/// Charges by linear digital numbers, e⁻, without any noise; and the digital numbers as they left the sensor.
fn recovered(sensor: &SensorModel, exposure: &Exposure) -> (Vec<f64>, Vec<u16>) {
    let data = charges();
    let planes = Planes::new(data.len(), 1, vec![Channel { name: "Y".to_owned(), data }]).expect("right sizes");
    let raw = expose(&planes, sensor, exposure, Stages::NONE, NoiseKey::default()).expect("valid");
    // Through a file, whose reader knows nothing but the table.
    let mut file = std::io::Cursor::new(Vec::new());
    write_dng(&raw, &mut file).expect("written");
    file.set_position(0);
    let linear = read_dng(file).expect("read").linear().into_owned();
    let black = f64::from(linear.black_level_dn.mean());
    let range = f64::from(linear.white_level_dn) - black;
    let per_dn = sensor.saturation_capacity(exposure).0 / range;
    (linear.data.iter().map(|&dn| (f64::from(dn) - black) * per_dn).collect(), raw.data)
}

#[test]
fn companded_numbers_give_their_electrons_back_within_a_step() {
    for companding in [knees(), Companding { bits: 10, curve: CompandingCurve::Gamma(2.2) }] {
        let sensor = companded(companding.clone());
        let (found, codes) = recovered(&sensor, &EXPOSURE);
        assert!(codes.iter().all(|&code| u32::from(code) < 1 << companding.bits) && codes.is_sorted());
        for (&truth, found) in charges().iter().zip(found) {
            // Half a step of the curve, here 1 e⁻ for each DN; rounding in the converter and in the table; and the
            // white level, which stands for the full well and is itself a number of the table.
            let level = f64::from(truth) + 1000.0;
            let step = match &companding.curve {
                CompandingCurve::KneePoints(_) if level < 1500.0 => 1.0,
                CompandingCurve::KneePoints(_) if level < 4005.0 => 5.0,
                CompandingCurve::KneePoints(_) if level < 16_020.0 => 15.0,
                CompandingCurve::KneePoints(_) => 49_535.0 / 1295.0,
                CompandingCurve::Gamma(gamma) => {
                    gamma / 1023.0 * level.powf(1.0 - 1.0 / gamma) * 65_535f64.powf(1.0 / gamma)
                }
            };
            let white_step = if companding.bits == 12 { 38.3 } else { 2.2 / 1023.0 * 65_535.0 };
            let room = 0.5 * step * 1.01 + 1.0 + f64::from(truth) / 60_000.0 * 0.5 * white_step;
            assert!((found - f64::from(truth)).abs() <= room, "{found} for {truth}, {room} allowed");
        }
    }
}

#[test]
fn logarithmic_pixels_give_their_electrons_back_within_a_step() {
    let sensor = logarithmic();
    for time in [0.1, 1.0, 20.0] {
        let exposure = Exposure { time: Seconds(time), ..EXPOSURE };
        let (found, codes) = recovered(&sensor, &exposure);
        let reference = 1000.0 * time;
        for ((&truth, found), code) in charges().iter().zip(found).zip(codes) {
            let truth = f64::from(truth);
            // By hand: K·q₀·ln(1 + q/q₀), rounded; f32 of the signal is good to 2⁻²⁴ of 65 535.
            let signal = 10.0 * reference * (1.0 + truth / reference).ln();
            if signal > 64_535.0 {
                assert_eq!(code, u16::MAX);
                continue;
            }
            assert!((f64::from(code) - 1000.0 - signal).abs() <= 0.51, "{code} for {truth} e⁻ in {time} s");
            // Half a number of the converter, in electrons there, and half a number of the table, which has 64 511 of
            // them; the white level is good to half a number at saturation.
            let step = (1.0 + truth / reference) / 10.0;
            let capacity = sensor.saturation_capacity(&exposure).0;
            let white_step = (1.0 + capacity / reference) / 10.0;
            let room = 0.55 * step + 0.55 * capacity / 64_511.0 + 0.55 * white_step * truth / capacity;
            assert!((found - truth).abs() <= room, "{found} for {truth} in {time} s, {room} allowed");
        }
    }
}

/// In a plot of logarithms numbers rise by γ for each step of the light, and the table of the file straightens them.
#[test]
fn a_video_curve_has_its_gamma_for_a_slope_and_a_way_back() {
    for gamma in [0.4, 0.45, 1.7, 5.0] {
        let sensor = curved(gamma);
        let (found, codes) = recovered(&sensor, &EXPOSURE);
        let number = |truth: f64| 64_535.0 * (truth / 64_535.0).powf(gamma);
        let mut slopes = Vec::new();
        for (i, ((&truth, found), code)) in charges().iter().zip(found).zip(&codes).enumerate() {
            let (truth, above) = (f64::from(truth), f64::from(*code) - 1000.0);
            assert!((above - number(truth)).abs() <= 0.51, "{above} for {truth}");
            // Half a number of the converter on both sides, half a number of the table, and half a number at white.
            let electrons = |number: f64| 64_535.0 * (number.max(0.0) / 64_535.0).powf(1.0 / gamma);
            let step = electrons(number(truth) + 0.51) - electrons(number(truth) - 0.51);
            let white_step = 1.0 / (gamma * (60_000.0f64 / 64_535.0).powf(gamma - 1.0));
            let room = step + 0.55 * 60_000.0 / 64_511.0 + 0.55 * white_step * truth / 60_000.0;
            assert!((found - truth).abs() <= room, "{found} for {truth}, {room} allowed");
            if above > 500.0 && i >= 100 {
                let before = f64::from(codes[i - 100]) - 1000.0;
                slopes.extend(
                    (before > 500.0).then(|| (above / before).ln() / (truth / f64::from(charges()[i - 100])).ln()),
                );
            }
        }
        // Numbers of 500 and more are good to 0.001, over a ratio of light of e^0.54.
        assert!(slopes.len() > 30 && slopes.iter().all(|slope| (slope - gamma).abs() < 0.004), "{gamma}");
    }
}

#[test]
fn digital_gain_leaves_the_start_of_a_curve() {
    let mut sensor = curved(0.5);
    sensor.full_well = Electrons(1e9);
    for db in [0.0, 6.0, 12.0] {
        let exposure = Exposure { digital_gain: Decibels(db), ..EXPOSURE };
        // √(q/R)·g = 1 at q = R/g².
        let capacity = sensor.saturation_capacity(&exposure).0;
        assert!((capacity / (64_535.0 / exposure.digital_gain.factor().powi(2)) - 1.0).abs() < 1e-12);
        for (part, is_full) in [(0.999, false), (1.001, true)] {
            let light = flat(&sensor, 2, 2, (capacity * part) as f32);
            let raw = expose(&light, &sensor, &exposure, Stages::NONE, NoiseKey::default()).expect("valid");
            assert_eq!(raw.data[0] == u16::MAX, is_full, "{db} dB, {part}: {}", raw.data[0]);
        }
        let iso = sensor.iso(&exposure).expect("has a speed");
        let gains = sensor.gains_for_iso(iso, Binning::NONE).expect("can do so");
        let again = Exposure { gain: gains[0], digital_gain: gains[1], ..EXPOSURE };
        assert!((sensor.iso(&again).expect("has a speed") / iso - 1.0).abs() < 1e-9);
    }
}

#[test]
fn equal_ratios_of_light_are_equal_steps_of_a_logarithmic_pixel() {
    let sensor = logarithmic();
    let number = |mean_e: f32, time: f64| {
        let exposure = Exposure { time: Seconds(time), ..EXPOSURE };
        let raw = expose(&flat(&sensor, 2, 2, mean_e), &sensor, &exposure, Stages::NONE, NoiseKey::default());
        f64::from(raw.expect("valid").data[0])
    };
    // Far above the reference: 10 000 DN for each factor of e, the quarter of a DN is what 1/(q/q₀) leaves at 20.
    let [a, b, c] = [20_000.0, 30_000.0, 45_000.0].map(|e| number(e, 1.0));
    assert!(
        ((b - a) - (c - b)).abs() < 10_000.0 * (1.0 / 20.0 - 2.0 / 30.0 + 1.0 / 45.0f64).abs() + 1.5,
        "{a} {b} {c}"
    );
    // The same photocurrent over another time gives the same i/i₀: numbers in proportion to the time.
    let [short, long] = [number(100.0, 0.1) - 1000.0, number(1000.0, 1.0) - 1000.0];
    assert!((10.0 * short - long).abs() <= 5.5, "{short} {long}");
}

#[test]
fn noise_of_nonlinear_sensors_is_predicted() {
    let mut sensors = [logarithmic(), companded(knees()), curved(0.45)];
    for sensor in &mut sensors {
        sensor.noise.read_out.change(|noise| noise.read = Electrons(3.0));
        for mean_e in [100.0f32, 2000.0, 10_000.0, 50_000.0] {
            let light = flat(sensor, 256, 256, mean_e);
            let raw = expose(&light, sensor, &EXPOSURE, Stages::ALL, NoiseKey::default()).expect("valid");
            let raw = raw.linear();
            let black = f64::from(raw.black_level_dn.mean());
            let per_dn = sensor.saturation_capacity(&EXPOSURE).0 / (f64::from(raw.white_level_dn) - black);
            let found: Moments = raw.data.iter().map(|&dn| (f64::from(dn) - black) * per_dn).collect();
            let expected = sensor.noise_variance(Electrons(mean_e.into()), &EXPOSURE);
            // 65 536 pixels: 5 σ of a variance is 2.8 %; the 16 bits of the table add a number's rounding, and the
            // white level is good to half a step, 0.03 %.
            let table = per_dn * per_dn / 12.0;
            assert!((found.variance() / (expected + table) - 1.0).abs() < 0.035, "{} for {expected}", found.variance());
            let spread = 5.0 * (expected / 65_536.0).sqrt() + 4e-4 * f64::from(mean_e);
            assert!((found.mean() - f64::from(mean_e)).abs() < spread, "{} for {mean_e}", found.mean());
        }
    }
}

#[test]
fn nonlinear_sensors_have_no_speed_and_no_photon_transfer_curve() {
    let sensor = logarithmic();
    assert!(sensor.iso(&EXPOSURE).is_none() && sensor.gains_for_iso(400.0, Binning::NONE).is_err());
    let linear = presets::model("sony-imx249-mono").expect("a preset");
    assert!(linear.linearisation(&EXPOSURE).is_none());
}
