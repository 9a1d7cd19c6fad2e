//! Fixed patterns, by which pixels differ in every image alike: dark current, defects, amplifiers, converters, crosstalk.

use photosite::image::Planes;
use photosite::math::statistics::Moments;
use photosite::raw::RawImage;
use photosite::sensor::{
    DarkCurrentLaw, Defects, Exposure, Kernel, NoiseKey, SensorModel, Stage, Stages, expose, presets,
};
use photosite::units::{Celsius, Electrons};

use crate::sensor_cases::{EXPOSURE, flat, quiet_sensor};

const SIDE: usize = 512;
const PIXELS: f64 = (SIDE * SIDE) as f64;

fn image(sensor: &SensorModel, mean_e: f32, stages: &[Stage], frame: u64) -> RawImage {
    let light = flat(sensor, SIDE, SIDE, mean_e);
    expose(&light, sensor, &EXPOSURE, Stages::only(stages), NoiseKey { seed: 17, frame }).expect("a valid exposure")
}

fn charge(raw: &RawImage) -> Vec<f64> {
    raw.data.iter().map(|&dn| f64::from(dn) - 1000.0).collect()
}

/// Mean of both, and their covariance.
fn covariance(a: &[f64], b: &[f64]) -> (f64, f64) {
    let mean: Moments = a.iter().chain(b).copied().collect();
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - mean.mean()) * (b - mean.mean())).sum();
    (mean.mean(), sum / a.len() as f64)
}

#[test]
fn dark_current_nonuniformity_keeps_the_mean_and_is_log_normal() {
    let mut sensor = quiet_sensor();
    sensor.noise.dark_current_e_per_s = 10_000.0;
    for ratio in [0.1, 0.4] {
        sensor.noise.dark_current_nonuniformity = ratio;
        let stages = [Stage::DarkCurrent, Stage::DarkCurrentNonuniformity];
        let [a, b] = [0, 1].map(|frame| charge(&image(&sensor, 0.0, &stages, frame)));
        // Shot noise of two images is independent, so their covariance is that of the pattern.
        let (mean, pattern) = covariance(&a, &b);
        assert!((mean - 10_000.0).abs() < 5.0 * 10_000.0 * ratio / PIXELS.sqrt(), "{mean}");
        let found = pattern.sqrt() / mean;
        // Variance of the sample variance: (kurtosis − 1)/n; that of a log-normal of σ = 0.4 is below 7. Half of it for
        // the deviation, 5 σ.
        assert!((found / ratio - 1.0).abs() < 5.0 * 0.5 * (6.0 / PIXELS).sqrt(), "{found} for {ratio}");
        // The median lies below the mean by the factor 1/√(1 + ratio²), and as many lie above e^s times it as below
        // e^-s.
        let s = (1.0 + ratio * ratio).ln().sqrt();
        let mut sorted = a;
        sorted.sort_by(f64::total_cmp);
        for (quantile, normal) in [(0.5, 0.0), (0.841_344_7, 1.0), (0.158_655_3, -1.0), (0.998_650_1, 3.0)] {
            let expected = 10_000.0 * (s * normal - 0.5 * s * s).exp();
            let found = sorted[(quantile * PIXELS) as usize];
            // In units of s: √(p(1 − p)/n) over the normal density, up to 0.02 at 3 σ; shot noise of 1 % of the mean
            // widens s by less than 0.5 % at ratio 0.1.
            assert!((found / expected).ln().abs() < s * 0.035, "{found} for {expected}");
        }
    }
}

#[test]
fn arrhenius_and_doubling_follow_the_temperature() {
    let mut sensor = quiet_sensor();
    sensor.noise.dark_current_e_per_s = 2000.0;
    // By hand, 25 → 45 °C. Gap of 1.12 eV: (318.15/298.15)^1.5 · exp(1.12/(2·8.617333e-5)·(1/298.15 − 1/318.15)) =
    // 1.102290 · exp(6498.530·2.108450e-4) = 1.102290 · 3.936069 = 4.338687.
    let law = DarkCurrentLaw::Arrhenius { band_gap_ev: Some(1.12) };
    for (law, factor) in [(law, 4.338_687), (DarkCurrentLaw::Doubling { interval_k: 8.0 }, 2f64.powf(2.5))] {
        sensor.noise.dark_current_law = law;
        let [cool, warm] = [25.0, 45.0].map(|celsius| {
            let exposure = Exposure { temperature: Celsius(celsius), ..EXPOSURE };
            let light = flat(&sensor, SIDE, SIDE, 0.0);
            let raw = expose(&light, &sensor, &exposure, Stages::ALL, NoiseKey::default()).expect("valid");
            charge(&raw).into_iter().collect::<Moments>()
        });
        let found = warm.mean() / cool.mean();
        // √(1/(2000·n)) for the cooler one, less for the other: 4.4e-5 together; 5 σ.
        assert!((found / factor - 1.0).abs() < 2.5e-4, "{found} for {factor}");
        // Doubling temperature within 2 %, as EMVA 1288 would find it.
        let interval = 20.0 * 2f64.ln() / found.ln();
        let expected = 20.0 * 2f64.ln() / factor.ln();
        assert!((interval / expected - 1.0).abs() < 0.02);
        // Thermal electrons have shot noise: √(2/n) = 0.28 %, 5 σ.
        assert!((warm.variance() / warm.mean() - 1.0).abs() < 0.014);
    }
}

#[test]
fn hot_pixels_are_always_the_same_and_exponentially_hot() {
    let mut sensor = quiet_sensor();
    sensor.noise.defects = Defects { hot: 0.02, hot_dark_current_e_per_s: 4000.0, ..Defects::default() };
    let [a, b] = [0, 1].map(|frame| charge(&image(&sensor, 0.0, &[Stage::HotPixels], frame)));
    let both = a.iter().zip(&b).filter(|(a, b)| **a > 0.0 && **b > 0.0).count() as f64 / PIXELS;
    assert!((both - 0.02).abs() < 5.0 * (0.02 / PIXELS).sqrt() + 1e-4, "{both}");
    let hot: Moments = a.iter().copied().filter(|e| *e > 0.0).collect();
    // 5200 pixels; an exponential distribution has mean and deviation alike: 5/√5200, and √(8)/2 times that.
    assert!((hot.mean() / 4000.0 - 1.0).abs() < 0.07, "{}", hot.mean());
    assert!((hot.variance().sqrt() / 4000.0 - 1.0).abs() < 0.1, "{}", hot.variance());
    // Their shot noise is new in each image: half the variance of the difference is the mean.
    let difference: Moments = a.iter().zip(&b).filter(|(a, _)| **a > 0.0).map(|(a, b)| a - b).collect();
    assert!((difference.variance() / 2.0 / hot.mean() - 1.0).abs() < 0.15, "{}", difference.variance());
}

#[test]
fn dead_and_stuck_pixels_are_where_the_serial_number_puts_them() {
    let mut sensor = quiet_sensor();
    sensor.noise.defects = Defects { dead: 0.01, stuck: 0.02, ..Defects::default() };
    let dead = |frame| charge(&image(&sensor, 3000.0, &[Stage::DeadPixels], frame));
    assert_eq!(dead(0), dead(1));
    let count = dead(0).iter().filter(|e| **e == 0.0).count() as f64;
    assert!((count / PIXELS - 0.01).abs() < 5.0 * (0.01 / PIXELS).sqrt(), "{count}");
    assert_eq!(dead(0).iter().filter(|e| **e == 3000.0).count() as f64 + count, PIXELS);
    let stuck = |frame| image(&sensor, 3000.0, &[Stage::StuckPixels], frame).data;
    assert_eq!(stuck(0), stuck(1));
    let numbers: Moments = stuck(0).iter().filter(|dn| **dn != 4000).map(|dn| f64::from(*dn)).collect();
    assert!((numbers.count() as f64 / PIXELS - 0.02).abs() < 5.0 * (0.02 / PIXELS).sqrt(), "{}", numbers.count());
    // Even over 0 to 65535: mean 32767.5, variance 2³²/12; 5200 of them, 5 σ.
    assert!((numbers.mean() / 32_767.5 - 1.0).abs() < 5.0 / (3.0f64 * 5200.0).sqrt(), "{}", numbers.mean());
    assert!((numbers.variance().sqrt() * 12f64.sqrt() / 65_536.0 - 1.0).abs() < 0.04);
}

/// A ramp of light over the pixels of an image, from 0 to `end_e`.
fn ramp(sensor: &SensorModel, end_e: f32) -> Planes {
    let mut light = flat(sensor, SIDE, SIDE, 0.0);
    for (i, e) in light.channels_mut()[0].data.iter_mut().enumerate() {
        *e = end_e * i as f32 / (PIXELS as f32 - 1.0);
    }
    light
}

#[test]
fn nonlinear_amplifiers_bend_as_stated_and_straight_ones_not_at_all() {
    let mut sensor = quiet_sensor();
    sensor.full_well = Electrons(50_000.0);
    let light = ramp(&sensor, 60_000.0);
    for coefficients in [vec![], vec![-0.04], vec![-0.04, 0.03]] {
        sensor.converter.amplifier_nonlinearity.clone_from(&coefficients);
        let stages = Stages::only(&[Stage::AmplifierNonlinearity, Stage::FullWell]);
        let raw = expose(&light, &sensor, &EXPOSURE, stages, NoiseKey::default()).expect("valid");
        for (e, found) in light.channels()[0].data.iter().zip(charge(&raw)) {
            let q = f64::from(*e).min(50_000.0);
            let x = q / 50_000.0;
            let factor: f64 = 1.0 + coefficients.iter().zip([x, x * x]).map(|(c, power)| c * power).sum::<f64>();
            // Half a DN, and f32's spacing at 50000.
            assert!((found - q * factor).abs() <= 0.504, "{found} for {q} with {coefficients:?}");
        }
        // The white level is where the full well ends up, and the inverse finds it again.
        let end = 50_000.0 * (1.0 + coefficients.iter().sum::<f64>());
        assert_eq!(f64::from(raw.white_level_dn) - 1000.0, end.round());
        assert!((sensor.charge_for(sensor.amplified(12_345.0)) - 12_345.0).abs() < 1e-6);
    }
}

#[test]
fn converters_bend_and_step_by_what_is_stated() {
    let mut sensor = quiet_sensor();
    sensor.converter.bits = 12;
    sensor.converter.black_level = 0.into();
    sensor.full_well = Electrons(4095.0);
    let light = ramp(&sensor, 4095.0);
    let run = |sensor: &SensorModel| {
        expose(&light, sensor, &EXPOSURE, Stages::ALL.without(Stage::ShotNoise), NoiseKey::default())
            .expect("valid")
            .data
    };
    let error = |sensor: &SensorModel| -> Vec<f64> {
        run(sensor).iter().zip(&light.channels()[0].data).map(|(dn, e)| f64::from(*dn) - f64::from(*e)).collect()
    };
    sensor.converter.inl_dn = -6.0;
    let nonlinear = error(&sensor);
    for (i, place) in [(0usize, 0.0), (SIDE * SIDE / 4, 0.25), (SIDE * SIDE / 2, 0.5), (SIDE * SIDE - 1, 1.0)] {
        let expected = -24.0 * place * (1.0 - place);
        assert!((nonlinear[i] - expected).abs() <= 0.51, "{} for {expected}", nonlinear[i]);
    }
    sensor.converter.inl_dn = 0.0;
    sensor.converter.dnl_dn = 0.35;
    let uneven: Moments = error(&sensor).into_iter().collect();
    // 1/12 of rounding; thresholds displaced evenly by up to u = 0.35·√1.5 add u²/3 = 0.06125. Every column has its own
    // converter, so 262144 errors are nearly independent: below 0.5 %, 5 σ.
    assert!((uneven.variance() / (1.0 / 12.0 + 0.061_25) - 1.0).abs() < 0.025, "{}", uneven.variance());
}

#[test]
fn columns_differ_in_gain_and_offset() {
    let mut sensor = quiet_sensor();
    (sensor.converter.column_gain, sensor.converter.column_offset_dn) = (0.01, 30.0);
    let of_columns = |mean_e: f32| -> Vec<f64> {
        let raw = image(&sensor, mean_e, &[Stage::ColumnAmplifiers], 0);
        assert!(raw.data.chunks(SIDE).all(|row| row == &raw.data[..SIDE]), "all rows are alike");
        charge(&raw)[..SIDE].to_vec()
    };
    let (dark, bright) = (of_columns(0.0), of_columns(20_000.0));
    let offsets: Moments = dark.iter().copied().collect();
    let gains: Moments = dark.iter().zip(&bright).map(|(dark, bright)| (bright - dark) / 20_000.0).collect();
    // 512 columns: 1/√1024 = 3.1 %; 4 σ.
    assert!((offsets.variance().sqrt() / 30.0 - 1.0).abs() < 0.125, "{}", offsets.variance());
    assert!((gains.variance().sqrt() / 0.01 - 1.0).abs() < 0.125, "{}", gains.variance());
    assert!((gains.mean() - 1.0).abs() < 5.0 * 0.01 / (SIDE as f64).sqrt());
}

#[test]
fn crosstalk_mixes_the_colours_of_a_mosaic_and_loses_nothing() {
    let mut sensor = presets::model("generic-cmos-color").expect("a preset");
    sensor.converter = quiet_sensor().converter;
    sensor.full_well = Electrons(60_000.0);
    // Red electrons wander farther than others.
    let far = Kernel::new(&[vec![0.0, 0.05, 0.0], vec![0.05, 0.8, 0.05], vec![0.0, 0.05, 0.0]]).expect("a kernel");
    sensor.crosstalk = Some(vec![far, Kernel::keep(), Kernel::keep()]);
    let mut light = flat(&sensor, SIDE, SIDE, 0.0);
    for (channel, mean_e) in light.channels_mut().iter_mut().zip([8000.0, 2000.0, 1000.0]) {
        channel.data.fill(mean_e);
    }
    let run = |stages: &[Stage]| {
        charge(&expose(&light, &sensor, &EXPOSURE, Stages::only(stages), NoiseKey::default()).expect("valid"))
    };
    let (mixed, unmixed) = (run(&[Stage::Crosstalk]), run(&[]));
    assert_eq!(mixed.iter().sum::<f64>(), unmixed.iter().sum::<f64>());
    // In the middle: R keeps 0.8 of its own; both kinds of G have two red neighbours; B, a diagonal away, none.
    let at = |x: usize, y: usize| mixed[(SIDE / 2 + y) * SIDE + SIDE / 2 + x];
    assert_eq!([at(0, 0), at(1, 0), at(0, 1), at(1, 1)], [6400.0, 2800.0, 2800.0, 1000.0]);
}
