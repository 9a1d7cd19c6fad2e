//! Sensors that are neither plain CMOS nor CCD: single-photon counters, two gains, stacked layers; and pixels whose
//! boundaries move.

use photosite::math::statistics::Moments;
use photosite::sensor::{
    Architecture, Converter, Counting, Exposure, NoiseKey, SensorModel, Spad, Stage, Stages, expose, presets,
};
use photosite::units::{Decibels, Electrons, Seconds};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::sensor_cases::{EXPOSURE, flat, quiet_sensor};

const SIDE: usize = 256;
const PIXELS: f64 = (SIDE * SIDE) as f64;

fn numbers(sensor: &SensorModel, exposure: &Exposure, mean_e: f32, frame: u64) -> Vec<f64> {
    let light = flat(sensor, SIDE, SIDE, mean_e);
    let raw = expose(&light, sensor, exposure, Stages::ALL, NoiseKey { seed: 4, frame }).expect("valid");
    raw.data.iter().map(|&dn| f64::from(dn) - f64::from(sensor.converter.black_level_dn(Default::default()))).collect()
}

fn moments(numbers: &[f64]) -> Moments {
    numbers.iter().copied().collect()
}

fn counter(counting: Counting) -> SensorModel {
    let mut sensor = quiet_sensor();
    sensor.converter.black_level = 0.into();
    SensorModel { architecture: Architecture::Spad(Spad { counting, afterpulsing: 0.0 }), ..sensor }
}

#[test]
fn detection_probability_of_a_one_bit_frame() {
    let frames = 1024;
    let sensor = counter(Counting::OneBit { frames });
    // ηφτ of one frame: detectable photons.
    for photons in [0.05f64, 0.5, 1.0, 3.0] {
        let light = photons * f64::from(frames);
        let mean = moments(&numbers(&sensor, &EXPOSURE, light as f32, 0)).mean();
        let (found, expected) = (mean / f64::from(frames), 1.0 - (-photons).exp());
        // 67 million frames: 5 σ is 0.3 % of P = 1 − e^(−0.05), the least of them.
        let spread = 5.0 * (expected * (1.0 - expected) / (PIXELS * f64::from(frames))).sqrt();
        assert!(spread < 0.005 * expected, "the test could not tell half a percent");
        assert!((found - expected).abs() < spread, "{photons} photons: {found} for {expected}");
    }
    // All frames bright: saturated, without noise.
    assert!(numbers(&sensor, &EXPOSURE, 1e6, 0).iter().all(|&count| count == f64::from(frames)));
}

#[test]
fn dark_counts_are_counted_like_photons() {
    let mut sensor = counter(Counting::OneBit { frames: 1 });
    sensor.noise.dark_current_e_per_s = 0.7;
    let mean = moments(&numbers(&sensor, &EXPOSURE, 0.5, 0)).mean();
    let expected = 1.0 - (-1.2f64).exp();
    assert!((mean - expected).abs() < 5.0 * (expected * (1.0 - expected) / PIXELS).sqrt(), "{mean} for {expected}");
}

#[test]
fn dark_counts_are_uneven_and_hot_pixels_stay_in_their_places() {
    // Without dead time counts are Poisson, of a mean of their own in every pixel.
    let mut sensor = counter(Counting::FreeRunning { dead_time: Seconds(0.0) });
    sensor.noise.dark_current_e_per_s = 50.0;
    sensor.noise.dark_current_nonuniformity = 0.5;
    let m = moments(&numbers(&sensor, &EXPOSURE, 0.0, 0));
    // 50 of shot noise and 25² of the pattern. The squares of such log-normal numbers spread by √7/256 of their mean.
    assert!((m.mean() - 50.0).abs() < 5.0 * (675.0 / PIXELS).sqrt(), "{}", m.mean());
    assert!((m.variance() / 675.0 - 1.0).abs() < 5.0 * 7f64.sqrt() / SIDE as f64, "{}", m.variance());

    sensor.noise.dark_current_e_per_s = 0.0;
    sensor.noise.defects.hot = 0.02;
    sensor.noise.defects.hot_dark_current_e_per_s = 400.0;
    let [a, b] = [0, 1].map(|frame| numbers(&sensor, &EXPOSURE, 0.0, frame));
    let hot = |counts: &[f64]| counts.iter().filter(|&&count| count > 0.0).count() as f64 / PIXELS;
    // Of a mean that is exponentially distributed around m, nothing is counted with the probability 1/(1 + m).
    let expected = 0.02 * (400.0 / 401.0);
    assert!((hot(&a) - expected).abs() < 5.0 * (expected / PIXELS).sqrt(), "{} for {expected}", hot(&a));
    let both: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a.min(*b)).collect();
    assert!(hot(&both) > 0.99 * hot(&a) && a != b);

    let off = Stages::ALL.without(Stage::HotPixels);
    let raw = expose(&flat(&sensor, SIDE, SIDE, 0.0), &sensor, &EXPOSURE, off, NoiseKey { seed: 4, frame: 0 });
    assert!(raw.expect("valid").data.iter().all(|&count| count == 0));
}

#[test]
fn dead_time_bends_the_counts() {
    let exposure = Exposure { time: Seconds(1e-3), ..EXPOSURE };
    let dead_time = Seconds(200e-9);
    let sensor = counter(Counting::FreeRunning { dead_time });
    for mean_e in [100.0f32, 2000.0, 20_000.0, 1e6] {
        let found = moments(&numbers(&sensor, &exposure, mean_e, 0)).mean();
        let n = f64::from(mean_e) / exposure.time.0;
        let expected = n / (1.0 + n * dead_time.0) * exposure.time.0;
        // The law is that of a long time; the first count, which waits for no dead time, adds less than half a count.
        assert!((found / expected - 1.0).abs() < 0.01, "{mean_e}: {found} for {expected}");
        assert!((found - expected).abs() < 0.5 + 5.0 * (expected / PIXELS).sqrt(), "{mean_e}: {found} for {expected}");
    }
    // Never more than one count in each dead time.
    let most = numbers(&sensor, &exposure, 1e9, 0).into_iter().fold(0.0, f64::max);
    assert!(most <= exposure.time.0 / dead_time.0 + 1.0, "{most}");
}

/// Standard deviation, e⁻, of normal noise of `read_e` that is rounded to whole DN at `k` DN/e⁻, and these once more at
/// `merged` DN/e⁻: summed over all numbers. Steps of 0.61 are not rounded as if by chance: 5 of them are nearly 3.
fn rounded_noise_e(read_e: f64, k: f64, merged: Option<f64>) -> f64 {
    let normal = Normal::new(0.0, read_e * k).expect("a width");
    let numbers = (-400..=400).map(f64::from).map(|n| {
        let number = merged.map_or(n / k, |merged| (n / k * merged).round() / merged);
        (normal.cdf(n + 0.5) - normal.cdf(n - 0.5), number)
    });
    let [mean, square] = numbers.fold([0.0; 2], |[m, s], (p, x)| [m + p * x, s + p * x * x]);
    (square - mean * mean).sqrt()
}

#[test]
fn two_gains_reach_from_the_noise_of_one_to_the_range_of_the_other() {
    // Full well or end of the converter over the noise in the dark, that of the amplifiers after rounding; from the
    // data sheets: full well, merged K, and read noise, K and range (4095 less black) of each gain.
    for (name, full_well, merged, [high, low]) in [
        ("andor-zyla-55", 30_000.0, 2.18, [[1.38, 3.571, 4045.0 / 3.571], [8.0, 0.1333, 4045.0 / 0.1333]]),
        ("automotive-hdr-color", 22_000.0, 2.244, [[0.83, 0.748, 4031.0 / 0.748], [3.05, 0.1832, 4031.0 / 0.1832]]),
    ] {
        let mut both = presets::model(name).expect("a preset");
        both.noise.prnu = Default::default();
        both.noise.read_out.change(|noise| noise.dsnu = Default::default());
        both.noise.dark_current_e_per_s = 0.0;
        // Noise with heavy tails leaves the variance of a sample without a useful error.
        both.noise.read_degrees_of_freedom = None;
        let dual = both.converter.dual_gain.clone().expect("two gains");
        let alone = |converter: &Converter, read: Electrons| {
            let mut sensor = SensorModel { converter: converter.clone(), ..both.clone() };
            sensor.noise.read_out.change(|noise| noise.read = read);
            sensor
        };
        let read = both.noise.read_out.at(Decibels(0.0)).read;
        let [high_alone, low_alone] = [alone(&dual.high, read), alone(&dual.low, dual.low_read_noise)];
        let decibels = |saturation: f64, noise: f64| 20.0 * (saturation / noise).log10();
        let range_db = |sensor: &SensorModel| {
            let gain = sensor.converter.system_gain(Decibels(0.0));
            let (a, b) = (numbers(sensor, &EXPOSURE, 0.0, 0), numbers(sensor, &EXPOSURE, 0.0, 1));
            let difference: Moments = a.iter().zip(&b).map(|(a, b)| a - b).collect();
            let saturation_e = moments(&numbers(sensor, &EXPOSURE, 1e6, 0)).mean() / gain;
            decibels(saturation_e, (difference.variance() / 2.0).sqrt()) + decibels(gain, 1.0)
        };
        let formula_db = |saturation: f64, [read, k, _]: [f64; 3], merged: Option<f64>| {
            decibels(saturation, rounded_noise_e(read, k, merged))
        };
        let found = [&both, &high_alone, &low_alone].map(range_db);
        let formulas = [
            formula_db(full_well, high, Some(merged)),
            formula_db(full_well.min(high[2]), high, None),
            formula_db(full_well.min(low[2]), low, None),
        ];
        // 65 536 differences know their standard deviation to 1/√(2·65 536), 0.28 %: 5 σ are 0.12 dB.
        for (found_db, formula_db) in found.iter().zip(formulas) {
            assert!((found_db - formula_db).abs() < 0.12, "{name}: {found:?} dB for {formulas:?} dB");
        }
        assert!(found[0] > found[1] && found[0] > found[2], "{name}: {found:?} dB");
    }
}

#[test]
fn two_gains_meet_in_a_straight_line() {
    let mut sensor = presets::model("andor-zyla-55").expect("a preset");
    sensor.noise.prnu = Default::default();
    sensor.noise.read_out.change(|noise| noise.dsnu = Default::default());
    let gain = sensor.converter.system_gain(Decibels(0.0));
    let dual = sensor.converter.dual_gain.clone().expect("two gains");
    for mean_e in [10.0f32, 900.0, 1050.0, 1100.0, 1300.0, 20_000.0] {
        let m = moments(&numbers(&sensor, &EXPOSURE, mean_e, 0));
        let low = f64::from(mean_e) > 1060.0;
        let step_e = 1.0 / if low { dual.low.system_gain(Decibels(0.0)) } else { dual.high.system_gain(Decibels(0.0)) };
        // Shot noise is wider than the steps of either converter, so that they leave the mean alone: 5 σ of it, with
        // the wider noise of the low gain.
        let spread = 5.0 * ((f64::from(mean_e) + 64.0 + step_e * step_e / 12.0) / PIXELS).sqrt() + 0.05;
        let dark = 0.1 * 2f64.powf(25.0 / 7.0);
        let expected = f64::from(mean_e) + dark;
        assert!((m.mean() / gain - expected).abs() < spread, "{} for {expected}", m.mean() / gain);
    }
}

#[test]
fn both_converters_of_two_gains_bend() {
    let mut sensor = presets::model("andor-zyla-55").expect("a preset");
    sensor.noise.prnu = Default::default();
    sensor.noise.read_out.change(|noise| noise.dsnu = Default::default());
    let gain = sensor.converter.system_gain(Decibels(0.0));
    for mean_e in [500.0f32, 15_000.0] {
        let before = moments(&numbers(&sensor, &EXPOSURE, mean_e, 0)).mean();
        let dual = sensor.converter.dual_gain.as_mut().expect("two gains");
        (dual.high.inl_dn, dual.low.inl_dn) = (20.0, 10.0);
        let converter = if mean_e < 1000.0 { dual.high.clone() } else { dual.low.clone() };
        let part = (50.0 + converter.conversion_gain_dn_per_e * f64::from(mean_e)) / 4095.0;
        let expected_e = converter.inl_dn * 4.0 * part * (1.0 - part) / converter.conversion_gain_dn_per_e;
        let found_e = (moments(&numbers(&sensor, &EXPOSURE, mean_e, 0)).mean() - before) / gain;
        // Noise is the same in both images, but the steps of a number are not; 5 σ, and what the bow bends within the
        // noise and the dark current of 1.2 e⁻.
        let step_e = 1.0 / converter.conversion_gain_dn_per_e;
        let tolerance = 5.0 * step_e * (2.0 / 12.0 / PIXELS).sqrt() + 0.005 * expected_e;
        assert!((found_e - expected_e).abs() < tolerance, "{mean_e}: {found_e} for {expected_e}");
        let dual = sensor.converter.dual_gain.as_mut().expect("two gains");
        (dual.high.inl_dn, dual.low.inl_dn) = (0.0, 0.0);
    }
}

#[test]
fn moving_boundaries_bend_the_photon_transfer_curve() {
    let per_e = [1e-6, 2e-6];
    let sensor = SensorModel { brighter_fatter_per_e: per_e, ..quiet_sensor() };
    for mean_e in [2000.0f32, 15_000.0, 40_000.0] {
        let image = numbers(&sensor, &EXPOSURE, mean_e, 0);
        let m = moments(&image);
        // Charge changes sides, but none is lost.
        assert!((m.mean() - f64::from(mean_e)).abs() < 5.0 * (f64::from(mean_e) / PIXELS).sqrt() + 0.01);
        let at = |x: usize, y: usize| image[y * SIDE + x] - m.mean();
        let covariance = |dx: usize, dy: usize| -> f64 {
            let all = (1..SIDE - 2).flat_map(|y| (1..SIDE - 2).map(move |x| (x, y)));
            all.map(|(x, y)| at(x, y) * at(x + dx, y + dy)).collect::<Moments>().mean()
        };
        let variance = covariance(0, 0);
        // The linear response of a pixel keeps 1 − 2(b_x + b_y) and gives b to each neighbour, b = a·μ/2: correlations
        // with standard deviations of 1/256, 5 σ.
        let [bx, by] = per_e.map(|a| a * m.mean() / 2.0);
        let keep = 1.0 - 2.0 * (bx + by);
        for (dx, dy, b) in [(1, 0, bx), (0, 1, by)] {
            let (found, expected) = (covariance(dx, dy) / m.mean(), 2.0 * b * keep);
            assert!((found - expected).abs() < 5.0 / SIDE as f64, "{mean_e}: {found} for {expected}");
        }
        // 0.99, 0.91 and 0.78: the ratio falls with the signal by more than what chance can hide.
        let expected = keep * keep + 2.0 * (bx * bx + by * by);
        assert!((variance / m.mean() - expected).abs() < 5.0 * 2f64.sqrt() / SIDE as f64, "{mean_e}: {variance}");
    }
    let off = expose(&flat(&sensor, 8, 8, 9000.0), &sensor, &EXPOSURE, Stages::NONE, NoiseKey::default());
    let on = Stages::only(&[Stage::BrighterFatter]);
    let flat_field = expose(&flat(&sensor, 8, 8, 9000.0), &sensor, &EXPOSURE, on, NoiseKey::default());
    assert_eq!(off, flat_field, "a field without contrast stays as it is");
}

#[test]
fn stacked_layers_share_the_photons() {
    let sensor = presets::model("generic-stacked-color").expect("a preset");
    // Together the layers absorb what silicon absorbs down to the bottom of the last one, by the law of Beer and
    // Lambert with absorption coefficients as M. A. Green printed them (2008, table 1), µm⁻¹.
    for (lambda_nm, per_um) in [(450.0f32, 2.41f64), (550.0, 0.639), (650.0, 0.279)] {
        let sum: f64 = sensor.quantum_efficiency.iter().map(|qe| f64::from(qe.eval(lambda_nm))).sum();
        let whole = 1.0 - (-per_um * 4.0).exp();
        // Three digits of the coefficient.
        assert!((sum / whole - 1.0).abs() < 1e-3, "{lambda_nm} nm: {sum} for {whole}");
    }
    let at = |lambda_nm: f32| sensor.quantum_efficiency.iter().map(|qe| qe.eval(lambda_nm)).collect::<Vec<_>>();
    let ([r, _, b], [r2, _, b2]) =
        (<[f32; 3]>::try_from(at(450.0)).expect("three"), <[f32; 3]>::try_from(at(650.0)).expect("three"));
    assert!(b > 5.0 * r && r2 > 4.0 * b2, "blue is absorbed above, red below");
    assert_eq!(sensor.full_well, Electrons(45_000.0));
}
