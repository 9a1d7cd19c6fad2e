//! Each stage of the sensor on its own: what it adds, and that it leaves all others alone.

use photosite::math::statistics::Moments;
use photosite::raw::RawImage;
use photosite::sensor::{
    DarkCurrentLaw, Exposure, FixedPattern, NoiseKey, SensorModel, Shutter, Stage, Stages, TelegraphSignal, expose,
    presets,
};
use photosite::units::{Celsius, Decibels, Electrons, Seconds};
use rstest::rstest;

use crate::sensor_cases::{EXPOSURE, flat, noisy_sensor, noisy_sensor_with, quiet_sensor, without};

const SIDE: usize = 256;
const PIXELS: f64 = (SIDE * SIDE) as f64;

fn image(sensor: &SensorModel, mean_e: f32, stages: Stages, seed: u64, frame: u64) -> RawImage {
    let light = flat(sensor, SIDE, SIDE, mean_e);
    expose(&light, sensor, &EXPOSURE, stages, NoiseKey { seed, frame }).expect("a valid exposure")
}

fn moments(raw: &RawImage) -> Moments {
    raw.data.iter().map(|&dn| f64::from(dn)).collect()
}

#[test]
fn the_full_well_clips_every_pixel() {
    for mut sensor in [quiet_sensor(), presets::model("generic-cmos-color").expect("a preset")] {
        // All noise of collecting charge, none of reading it out; ten times as much light as fits.
        sensor.full_well = Electrons(10_000.0);
        sensor.noise.prnu = FixedPattern::of_pixels(0.01);
        sensor.noise.dark_current_e_per_s = 50.0;
        sensor.noise.read_out.change(|noise| noise.dsnu = FixedPattern::of_pixels(0.0));
        sensor.noise.read_out.change(|noise| noise.read = Electrons(0.0));
        let raw = image(&sensor, 100_000.0, Stages::ALL, 3, 0);
        assert!(raw.data.iter().all(|&dn| dn == raw.white_level_dn));
        let gain = sensor.converter.conversion_gain_dn_per_e;
        let expected = f64::from(sensor.converter.black_level_dn(Default::default())) + 10_000.0 * gain;
        assert!((f64::from(raw.white_level_dn) - expected).abs() <= 0.5);
    }
}

#[test]
fn the_converter_clips_what_the_well_does_not() {
    let mut sensor = quiet_sensor();
    sensor.converter.bits = 10;
    sensor.converter.black_level = 20.into();
    let raw = image(&sensor, 50_000.0, Stages::ALL, 3, 0);
    assert!(raw.data.iter().all(|&dn| dn == 1023));
    assert_eq!(raw.white_level_dn, 1023);
    assert_eq!(sensor.saturation_capacity(&EXPOSURE), Electrons(1003.0));
}

#[test]
fn dark_current_doubles_every_so_many_kelvin() {
    let mut sensor = quiet_sensor();
    sensor.noise.dark_current_e_per_s = 100.0;
    sensor.noise.dark_current_law = DarkCurrentLaw::Doubling { interval_k: 6.5 };
    let light = flat(&sensor, SIDE, SIDE, 0.0);
    for (kelvin, expected) in [(-13.0, 25.0), (0.0, 100.0), (6.5, 200.0), (13.0, 400.0)] {
        let exposure = Exposure { temperature: Celsius(25.0 + kelvin), ..EXPOSURE };
        let raw = expose(&light, &sensor, &exposure, Stages::ALL, NoiseKey::default()).expect("valid");
        let m = moments(&raw);
        // Poisson: the mean of N pixels has the standard deviation √(μ/N), their variance μ·√(2/N + 1/(μN)); 5 σ.
        assert!((m.mean() - 1000.0 - expected).abs() < 5.0 * (expected / PIXELS).sqrt(), "{}", m.mean());
        let spread = ((2.0 * expected * expected + expected) / PIXELS).sqrt();
        assert!((m.variance() - expected).abs() < 5.0 * spread, "{}", m.variance());
    }
    let glowing = Exposure { temperature: Celsius(800.0), ..EXPOSURE };
    let raw = expose(&light, &sensor, &glowing, Stages::ALL, NoiseKey::default()).expect("valid");
    assert!(raw.data.iter().all(|&dn| dn == raw.white_level_dn));
    let twice = Exposure { time: Seconds(2.0), ..EXPOSURE };
    assert_eq!(sensor.noise.dark_electrons(twice.temperature, twice.time), Electrons(200.0));
}

#[test]
fn prnu_is_the_spatial_deviation_of_the_response() {
    let mut sensor = quiet_sensor();
    sensor.noise.prnu = FixedPattern::of_pixels(0.008);
    let raw = image(&sensor, 20_000.0, Stages::only(&[Stage::PhotoResponse]), 5, 0);
    let m = moments(&raw);
    let prnu = (m.variance() - 1.0 / 12.0).sqrt() / 20_000.0;
    // The sample deviation of N normal numbers has the relative standard deviation 1/√(2N); 5 σ.
    assert!((prnu / 0.008 - 1.0).abs() < 5.0 / (2.0 * PIXELS).sqrt(), "{prnu}");
    assert!((m.mean() - 21_000.0).abs() < 5.0 * 160.0 / PIXELS.sqrt());
    // It scales with the light: twice the light, twice the deviation, pixel by pixel.
    let dim = image(&sensor, 10_000.0, Stages::only(&[Stage::PhotoResponse]), 5, 0);
    let differs = |(&bright, &dim): (&u16, &u16)| (f64::from(bright) - 1000.0 - 2.0 * (f64::from(dim) - 1000.0)).abs();
    assert!(
        raw.data.iter().zip(&dim.data).map(differs).all(|d| d <= 1.5),
        "rounded at half a DN, and at twice half a DN"
    );
}

#[test]
fn dsnu_is_the_spatial_deviation_of_the_dark_signal() {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.dsnu = FixedPattern::of_pixels(9.0));
    for mean_e in [0.0, 20_000.0] {
        let raw = image(&sensor, mean_e, Stages::only(&[Stage::DarkOffset]), 5, 0);
        let m = moments(&raw);
        let dsnu = (m.variance() - 1.0 / 12.0).sqrt();
        assert!((dsnu / 9.0 - 1.0).abs() < 5.0 / (2.0 * PIXELS).sqrt(), "{dsnu}");
        assert!((m.mean() - 1000.0 - f64::from(mean_e)).abs() < 5.0 * 9.0 / PIXELS.sqrt());
    }
}

#[test]
fn fixed_patterns_stay_from_frame_to_frame_and_temporal_noise_does_not() {
    let mut sensor = quiet_sensor();
    sensor.noise.prnu = FixedPattern::of_pixels(0.01);
    sensor.noise.read_out.change(|noise| noise.dsnu = FixedPattern::of_pixels(5.0));
    sensor.noise.read_out.change(|noise| noise.read = Electrons(5.0));
    let fixed = Stages::only(&[Stage::PhotoResponse, Stage::DarkOffset]);
    assert_eq!(image(&sensor, 5000.0, fixed, 1, 0).data, image(&sensor, 5000.0, fixed, 1, 9).data);
    assert_eq!(image(&sensor, 5000.0, fixed, 1, 0).data, image(&sensor, 5000.0, fixed, 2, 0).data);
    for stages in [Stages::only(&[Stage::ShotNoise]), Stages::only(&[Stage::ReadNoise])] {
        let (a, b) = (image(&sensor, 5000.0, stages, 1, 0), image(&sensor, 5000.0, stages, 1, 1));
        // The correlation of N independent pairs has the standard deviation 1/√N; 5 σ.
        let (ma, mb) = (moments(&a), moments(&b));
        let product = |(&a, &b): (&u16, &u16)| (f64::from(a) - ma.mean()) * (f64::from(b) - mb.mean());
        let covariance: f64 = a.data.iter().zip(&b.data).map(product).sum::<f64>() / PIXELS;
        let correlation = covariance / (ma.variance() * mb.variance()).sqrt();
        assert!(correlation.abs() < 5.0 / PIXELS.sqrt(), "{correlation}");
    }
}

/// Effects that are added to or multiplied with the signal of each pixel, for ever: all of them belong to the serial number.
#[rstest]
#[case::global(false)]
#[case::scanning(true)]
fn fixed_patterns_belong_to_the_serial_number(#[case] scans: bool) {
    const STAGES: [Stage; 6] = [
        Stage::PhotoResponse,
        Stage::DeadPixels,
        Stage::DarkOffset,
        Stage::ColumnAmplifiers,
        Stage::ConverterNonlinearity,
        Stage::StuckPixels,
    ];
    let mut sensor = noisy_sensor();
    if scans {
        sensor.shutter = Shutter::Scanning { line_time: EXPOSURE.time };
    }
    let of = |serial, stage, seed, frame| {
        image(&SensorModel { serial, ..sensor.clone() }, 1500.0, Stages::only(&[stage]), seed, frame)
    };
    for stage in STAGES {
        let pattern = of(3, stage, 1, 0);
        assert_eq!(pattern.data, of(3, stage, 2, 7).data, "{stage:?}: neither seed nor frame changes it");
        let other = of(4, stage, 1, 0);
        assert_ne!(pattern.data, other.data, "{stage:?}");
        // A line camera has one row of pixels, so that there are SIDE numbers in place of SIDE²; of columns, in all.
        // The correlation of N independent pairs has the standard deviation 1/√N; 5 σ. Converters bend the same way,
        // and no pixel is alike.
        if stage != Stage::ConverterNonlinearity {
            let (a, b) = (moments(&pattern), moments(&other));
            let product = |(&x, &y): (&u16, &u16)| (f64::from(x) - a.mean()) * (f64::from(y) - b.mean());
            let covariance = pattern.data.iter().zip(&other.data).map(product).sum::<f64>() / PIXELS;
            let correlation = covariance / (a.variance() * b.variance()).sqrt();
            assert!(correlation.abs() < 5.0 / (SIDE as f64).sqrt(), "{stage:?}: {correlation}");
        }
    }
    // Dark current is new in each image, but not where there is more of it: means over many frames are alike.
    for stage in [Stage::DarkCurrentNonuniformity, Stage::HotPixels] {
        let mean = |serial, seed| {
            let stages = Stages::only(&[Stage::DarkCurrent, stage]);
            let mut sum = vec![0.0; SIDE * SIDE];
            for frame in 0..8 {
                let raw = image(&SensorModel { serial, ..sensor.clone() }, 0.0, stages, seed, frame);
                sum.iter_mut().zip(&raw.data).for_each(|(sum, &dn)| *sum += f64::from(dn));
            }
            sum
        };
        let (one, again, other) = (mean(3, 1), mean(3, 2), mean(4, 1));
        let correlation = |a: &[f64], b: &[f64]| {
            let moments = |v: &[f64]| v.iter().copied().collect::<Moments>();
            let (ma, mb) = (moments(a), moments(b));
            let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - ma.mean()) * (b - mb.mean())).sum();
            sum / PIXELS / (ma.variance() * mb.variance()).sqrt()
        };
        // 400 e⁻ that differ by 30 %, or 300 e⁻ in 2 % of the pixels, over the shot noise of 8 frames: the pattern is
        // (120 e⁻)² of (120² + 400/8) (e⁻)², 0.997 of all, or 0.02·2·300² of that + 400/8, 0.986.
        assert!(correlation(&one, &again) > 0.97, "{stage:?}: {}", correlation(&one, &again));
        assert!(correlation(&one, &other).abs() < 5.0 / (SIDE as f64).sqrt(), "{stage:?}");
    }
}

/// A trap belongs to the pixel; when it fills and empties is new with another seed.
#[test]
fn telegraph_signals_of_another_take_come_from_the_same_pixels() {
    let mut sensor = quiet_sensor();
    sensor.noise.telegraph =
        TelegraphSignal { pixels: 0.1, amplitude: Electrons(150.0), high: Seconds(1.0), low: Seconds(1.0) };
    let of = |serial, seed| {
        let raw = image(&SensorModel { serial, ..sensor.clone() }, 0.0, Stages::only(&[Stage::Telegraph]), seed, 0);
        raw.data.iter().map(|&dn| f64::from(dn) - 1000.0).collect::<Vec<_>>()
    };
    let (one, again, other) = (of(3, 1), of(3, 2), of(4, 1));
    // Large enough for two rounded numbers of the same height to be told from those of another.
    let shows = |v: &f64| v.abs() > 10.0;
    let count = |values: &[f64]| values.iter().filter(|v| shows(v)).count() as f64;
    let both = |a: &[f64], b: &[f64]| -> Vec<(f64, f64)> {
        a.iter().copied().zip(b.iter().copied()).filter(|(a, b)| shows(a) && shows(b)).collect()
    };
    let alike = both(&one, &again).len() as f64;
    // Half a DN up or down may put one of two on the other side of the limit, at a density of 1/75 per DN: 0.7 %.
    assert!(alike >= 0.98 * count(&one), "{alike} of {}", count(&one));
    assert!(both(&one, &again).iter().all(|(a, b)| (a.abs() - b.abs()).abs() <= 1.0), "up or down");
    let same = both(&one, &again).iter().filter(|(a, b)| a * b > 0.0).count() as f64 / count(&one);
    // Each second, by chance: 5 σ of a binomial distribution.
    assert!((same - 0.5).abs() < 2.5 / count(&one).sqrt(), "{same}");
    let alike = both(&one, &other).len() as f64 / count(&one);
    assert!((alike - 0.1).abs() < 5.0 * (0.09 / count(&one)).sqrt(), "{alike}");
}

#[test]
fn the_black_level_keeps_negative_noise() {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.read = Electrons(20.0));
    let kept = moments(&image(&sensor, 0.0, Stages::ALL, 4, 0));
    assert!((kept.mean() - 1000.0).abs() < 5.0 * 20.0 / PIXELS.sqrt(), "{}", kept.mean());
    assert!((kept.variance().sqrt() / 20.0 - 1.0).abs() < 5.0 / (2.0 * PIXELS).sqrt() + 1e-3);
    // Without a black level half of the noise is lost: the mean of max(0, n) is σ/√(2π), its variance σ²·(½ − 1/(2π)).
    sensor.converter.black_level = 0.into();
    let lost = moments(&image(&sensor, 0.0, Stages::ALL, 4, 0));
    let expected = 20.0 / (2.0 * std::f64::consts::PI).sqrt();
    let spread = 20.0 * (0.5 - 0.5 / std::f64::consts::PI).sqrt();
    // Rounding moves the mean of the numbers above zero by less than 1/(12·20·2).
    assert!((lost.mean() - expected).abs() < 5.0 * spread / PIXELS.sqrt() + 2e-3, "{} for {expected}", lost.mean());
}

/// Contribution of a stage to every pixel, with all of `others` beside it.
fn added_by(stage: Stage, others: Stages, sensor: &SensorModel) -> Vec<i32> {
    let run = |stages| image(sensor, 2000.0, stages, 11, 2).data;
    let (with, without) = (run(others.with(stage)), run(others.without(stage)));
    with.into_iter().zip(without).map(|(a, b)| i32::from(a) - i32::from(b)).collect()
}

#[test]
fn switching_a_stage_off_changes_no_other_bit_by_bit() {
    for stage in Stage::ALL {
        let sensor = noisy_sensor_with(stage);
        // Light and dark in turn, so that crosstalk has something to mix.
        let mut light = flat(&sensor, SIDE, SIDE, 0.0);
        for (i, electrons) in light.channels_mut()[0].data.iter_mut().enumerate() {
            *electrons = 1500.0 + (i % 3 * 500) as f32;
        }
        let run = |sensor: &SensorModel, stages| {
            expose(&light, sensor, &EXPOSURE, stages, NoiseKey { seed: 11, frame: 2 }).expect("a valid exposure").data
        };
        let all = run(&sensor, Stages::ALL);
        let off = run(&sensor, Stages::ALL.without(stage));
        assert!(all != off, "{stage:?} does nothing");
        // A sensor without the effect must give the bytes of one whose stage is switched off.
        if let Some(ideal) = without(&sensor, stage) {
            assert!(run(&ideal, Stages::ALL) == off, "{stage:?}");
        }
    }
}

#[test]
fn what_a_stage_adds_does_not_depend_on_the_others() {
    let sensor = noisy_sensor();
    let adding = [
        Stage::ShotNoise,
        Stage::DarkCurrent,
        Stage::HotPixels,
        Stage::ResetNoise,
        Stage::Telegraph,
        Stage::Flicker,
        Stage::DarkOffset,
        Stage::ReadNoise,
        Stage::RowNoise,
        Stage::ColumnNoise,
    ];
    for stage in adding {
        let alone = added_by(stage, Stages::NONE, &sensor);
        for other in adding.into_iter().filter(|&other| other != stage) {
            let beside = added_by(stage, Stages::NONE.with(other), &sensor);
            // Two differences of numbers rounded by half a DN each.
            assert!(alone.iter().zip(&beside).all(|(a, b)| (a - b).abs() <= 2), "{stage:?} beside {other:?}");
        }
    }
}

#[test]
fn the_same_key_gives_the_same_numbers_on_any_number_of_threads() {
    // For a second, however soon a line camera comes to its next line.
    let preset = |name| SensorModel { shutter: Shutter::Global, ..presets::model(name).expect("listed") };
    let sensors = presets::names().map(|name| (name, preset(name)));
    for (name, sensor) in sensors.chain([("every effect", noisy_sensor())]) {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
            pool.install(|| image(&sensor, 3000.0, Stages::ALL, 21, 4))
        };
        let one = run(1);
        assert_eq!(one, run(2), "{name}");
        assert_eq!(one, run(3), "{name}");
        assert_ne!(one.data, image(&sensor, 3000.0, Stages::ALL, 22, 4).data, "{name}");
    }
}

#[test]
fn every_pixel_sees_its_own_channel() {
    let sensor = presets::model("generic-cmos-color").expect("a preset");
    let mut light = flat(&sensor, 5, 3, 0.0);
    for (channel, mean_e) in light.channels_mut().iter_mut().zip([1000.0, 2000.0, 3000.0]) {
        channel.data.fill(mean_e);
    }
    let raw = expose(&light, &sensor, &EXPOSURE, Stages::NONE, NoiseKey::default()).expect("valid");
    let dn = |mean_e: f64| (mean_e * sensor.converter.conversion_gain_dn_per_e + 64.0).round() as u16;
    let [r, g, b] = [1000.0, 2000.0, 3000.0].map(dn);
    assert_eq!(raw.data, [r, g, r, g, r, g, b, g, b, g, r, g, r, g, r]);
}

#[test]
fn impossible_exposures_are_refused_by_key() {
    let sensor = quiet_sensor();
    for (exposure, key) in [
        (Exposure { time: Seconds(0.0), ..EXPOSURE }, "time_s"),
        (Exposure { time: Seconds(f64::NAN), ..EXPOSURE }, "time_s"),
        (Exposure { gain: Decibels(30.0), ..EXPOSURE }, "gain_db"),
        (Exposure { gain: Decibels(-1.0), ..EXPOSURE }, "gain_db"),
        (Exposure { temperature: Celsius(-300.0), ..EXPOSURE }, "temperature_c"),
        (Exposure { temperature: Celsius(f64::INFINITY), ..EXPOSURE }, "temperature_c"),
    ] {
        let error = expose(&flat(&sensor, 2, 2, 1.0), &sensor, &exposure, Stages::ALL, NoiseKey::default());
        assert_eq!(error.expect_err("refused").key, key);
    }
    for electrons in [-1.0, f32::NAN, f32::INFINITY] {
        let light = flat(&sensor, 2, 2, electrons);
        let error = expose(&light, &sensor, &EXPOSURE, Stages::ALL, NoiseKey::default()).expect_err("refused");
        assert!(error.message.contains("column 0, row 0"), "{error}");
    }
    let colour = presets::model("generic-cmos-color").expect("a preset");
    let error = expose(&flat(&sensor, 2, 2, 1.0), &colour, &EXPOSURE, Stages::ALL, NoiseKey::default());
    assert!(error.expect_err("refused").message.contains("channel R"));
}

#[test]
fn rows_and_columns_of_a_pattern_stand_apart() {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.dsnu = FixedPattern { pixel: 200.0, row: 120.0, column: 70.0 });
    sensor.noise.prnu = FixedPattern { pixel: 0.02, row: 0.012, column: 0.007 };
    for (mean_e, stage) in [(10_000.0, Stage::PhotoResponse), (0.0, Stage::DarkOffset)] {
        let raw = image(&sensor, mean_e, Stages::only(&[stage]), 6, 0);
        let at = |x: usize, y: usize| f64::from(raw.data[y * SIDE + x]);
        let row_means: Moments = (0..SIDE).map(|y| (0..SIDE).map(|x| at(x, y)).sum::<f64>() / SIDE as f64).collect();
        let column_means: Moments = (0..SIDE).map(|x| (0..SIDE).map(|y| at(x, y)).sum::<f64>() / SIDE as f64).collect();
        // Means of rows have the variance of rows, and of pixels over their number. The sample deviation of 256 normal
        // numbers is good to 1/√512; 4 σ. Rounding adds 1/12 DN² to pixels.
        let expected = |shared: f64| (shared.powi(2) + (200.0 * 200.0 + 1.0 / 12.0) / SIDE as f64).sqrt();
        let tolerance = 4.0 / (2.0 * SIDE as f64).sqrt();
        for (means, shared) in [(row_means, 120.0), (column_means, 70.0)] {
            let ratio = means.variance().sqrt() / expected(shared);
            assert!((ratio - 1.0).abs() < tolerance, "{stage:?}: {ratio} of {shared}");
        }
        let residual: Moments = (0..SIDE * SIDE)
            .map(|i| {
                let (x, y) = (i % SIDE, i / SIDE);
                let row = (0..SIDE).map(|x| at(x, y)).sum::<f64>() / SIDE as f64;
                let next = (0..SIDE).map(|x| at(x, (y + 1) % SIDE)).sum::<f64>() / SIDE as f64;
                // Differences down a column drop its part; row means drop the rows'.
                (at(x, y) - row) - (at(x, (y + 1) % SIDE) - next)
            })
            .collect();
        // Differences of neighbours: variance 2σ², correlated −½ with the next one, which makes their sample variance
        // worth 2/3 as many: relative 1/√(2·2N/3); 5 σ. Row means take 1/256 away.
        let pixel = (residual.variance() / 2.0 / (1.0 - 1.0 / SIDE as f64)).sqrt();
        assert!((pixel / 200.0 - 1.0).abs() < 5.0 * (0.75 / PIXELS).sqrt(), "{stage:?}: {pixel}");
    }
}
