//! Each kind of temporal noise by itself: its own statistic must be what went in.

use photosite::math::statistics::Moments;
use photosite::sensor::{
    Exposure, Flicker, FlickerOrder, NoiseKey, Reset, SensorModel, Stage, Stages, TelegraphSignal, expose,
};
use photosite::units::{Celsius, Electrons, Seconds};
use statrs::distribution::{Continuous, ContinuousCDF, StudentsT};

use crate::sensor_cases::{EXPOSURE, flat, noisy_sensor, quiet_sensor};

/// Noise that the stages add to flat light, without the black level and the light, row by row: e⁻, as sensors here have 1
/// DN/e⁻.
fn noise(sensor: &SensorModel, size: [usize; 2], mean_e: f32, stages: &[Stage], frame: u64) -> Vec<f64> {
    let light = flat(sensor, size[0], size[1], mean_e);
    let key = NoiseKey { seed: 31, frame };
    let raw = expose(&light, sensor, &EXPOSURE, Stages::only(stages), key).expect("a valid exposure");
    raw.data.iter().map(|&dn| f64::from(dn) - 1000.0 - f64::from(mean_e)).collect()
}

fn moments(numbers: &[f64]) -> Moments {
    numbers.iter().copied().collect()
}

/// Means of the rows of an image, or of its columns.
fn row_means(noise: &[f64], width: usize) -> Moments {
    noise.chunks(width).map(|row| row.iter().sum::<f64>() / width as f64).collect()
}

fn column_means(noise: &[f64], width: usize) -> Moments {
    let height = noise.len() / width;
    (0..width).map(|x| noise[x..].iter().step_by(width).sum::<f64>() / height as f64).collect()
}

#[test]
fn shot_noise_has_the_variance_of_its_mean() {
    for mean_e in [15.0f32, 4000.0, 50_000.0] {
        let m = moments(&noise(&quiet_sensor(), [2048, 2048], mean_e, &[Stage::ShotNoise], 0));
        let ratio = m.variance() / (m.mean() + f64::from(mean_e));
        // √(2/2²²) = 0.07 %, so 0.3 % is more than 4 σ.
        assert!((ratio - 1.0).abs() < 0.003, "{ratio} at {mean_e} e⁻");
    }
}

#[test]
fn reset_noise_is_that_of_its_capacitance_and_gone_with_double_sampling() {
    let mut sensor = quiet_sensor();
    for (reset, expected) in [
        // √(k·298.15 K·10 fF)/e by hand: √(4.116415e-35)/1.602177e-19 = 40.0453.
        (Reset::Capacitance(10e-15), 40.0453),
        (Reset::Fixed(Electrons(25.0)), 25.0),
        (Reset::Cancelled, 0.0),
    ] {
        sensor.noise.reset = reset;
        let m = moments(&noise(&sensor, [512, 512], 100.0, &[Stage::ResetNoise], 0));
        if expected == 0.0 {
            assert_eq!(m.variance(), 0.0);
            continue;
        }
        let sigma = (m.variance() - 1.0 / 12.0).sqrt();
        // 1/√(2·2¹⁸) = 0.14 %, 5 σ.
        assert!((sigma / expected - 1.0).abs() < 0.007, "{sigma} for {expected}");
    }
}

#[test]
fn rows_and_columns_share_their_noise_in_one_image_only() {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.row = Electrons(120.0));
    sensor.noise.read_out.change(|noise| noise.column = Electrons(80.0));
    let (few, many) = (4, 20_000);
    for (stage, size, expected) in [(Stage::RowNoise, [few, many], 120.0), (Stage::ColumnNoise, [many, few], 80.0)] {
        let [a, b] = [0, 1].map(|frame| noise(&sensor, size, 1000.0, &[stage], frame));
        let (rows, columns) = (row_means(&a, size[0]), column_means(&a, size[0]));
        let (of_lines, across) = if stage == Stage::RowNoise { (rows, columns) } else { (columns, rows) };
        // 1/√(2·20000) = 0.5 %; 3 % is 6 σ.
        let sigma = of_lines.variance().sqrt();
        assert!((sigma / expected - 1.0).abs() < 0.03, "{stage:?}: {sigma}");
        // The pixels of a line are all the same, and across lines their mean is.
        let m = moments(&a);
        assert!((m.variance() / of_lines.variance() - 1.0).abs() < 1e-3);
        assert!(across.variance() < 1e-3, "{}", across.variance());
        let covariance = a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64;
        assert!(covariance.abs() < 5.0 * expected * expected / (many as f64).sqrt(), "{covariance}");
    }
}

#[test]
fn every_pixel_keeps_its_own_read_noise_and_all_together_the_stated_one() {
    const FRAMES: u64 = 64;
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.read = Electrons(500.0));
    sensor.noise.read_spread = 0.4;
    let logarithms = |sensor: &SensorModel, first: u64| -> Vec<f64> {
        let frames =
            (first..first + FRAMES).map(|frame| noise(sensor, [128, 96], 30_000.0, &[Stage::ReadNoise], frame));
        let frames: Vec<Vec<f64>> = frames.collect();
        (0..128 * 96).map(|i| frames.iter().map(|f| f[i]).collect::<Moments>().variance().ln()).collect()
    };
    let found = logarithms(&sensor, 0);
    let m: Moments = found.iter().copied().collect();
    // ln σ̂² = ln σ² + 2·(t·n − t²) + ln(χ²/k), whose mean and variance are ψ(k/2) − ln(k/2) and ψ′(k/2).
    let (t2, half) = (1.16f64.ln(), (FRAMES - 1) as f64 / 2.0);
    let mean = 2.0 * 500f64.ln() - 2.0 * t2 - 0.5 / half - 1.0 / (12.0 * half * half);
    let variance = 4.0 * t2 + 1.0 / half + 0.5 / half.powi(2);
    let n = found.len() as f64;
    assert!((m.mean() - mean).abs() < 5.0 * (variance / n).sqrt(), "{} for {mean}", m.mean());
    assert!((m.variance() / variance - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{} for {variance}", m.variance());
    // The same pixels are noisy in other frames, and others in another sensor: correlation 4·t²/variance, or none.
    let correlation = |other: &[f64]| {
        let o: Moments = other.iter().copied().collect();
        let product: f64 = found.iter().zip(other).map(|(a, b)| (a - m.mean()) * (b - o.mean())).sum();
        product / n / (m.variance() * o.variance()).sqrt()
    };
    assert!((correlation(&logarithms(&sensor, 100)) - 4.0 * t2 / variance).abs() < 5.0 / n.sqrt());
    sensor.serial += 1;
    assert!(correlation(&logarithms(&sensor, 200)).abs() < 5.0 / n.sqrt());
}

#[test]
fn heavy_tails_have_the_quantiles_of_their_distribution_and_the_stated_deviation() {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.read = Electrons(500.0));
    for freedom in [3.0, 6.0] {
        sensor.noise.read_degrees_of_freedom = Some(freedom);
        let mut values = noise(&sensor, [1024, 512], 30_000.0, &[Stage::ReadNoise], 0);
        values.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        // Student's t of unit scale has the variance ν/(ν − 2).
        let scale = 500.0 * ((freedom - 2.0) / freedom).sqrt();
        let t = StudentsT::new(0.0, 1.0, freedom).expect("a distribution");
        for p in [1e-4, 1e-3, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999] {
            let expected = t.inverse_cdf(p);
            let quantile = values[(p * n) as usize] / scale;
            // A sample quantile has the standard deviation √(p(1 − p)/n)/f; 5 σ. Rounding: half a DN.
            let tolerance = 5.0 * (p * (1.0 - p) / n).sqrt() / t.pdf(expected) + 0.5 / scale;
            assert!((quantile - expected).abs() < tolerance, "ν = {freedom}, {p}: {quantile} for {expected}");
        }
        // Far more lies beyond 5 σ than the normal distribution's 6e-7.
        let far = values.iter().filter(|v| v.abs() > 2500.0).count() as f64 / n;
        assert!(far > 5e-4, "{far}");
    }
}

/// Power of sequences at a frequency in cycles a sample, through a Hann window that keeps strong low frequencies from
/// leaking, in any unit.
fn power(sequences: &[Vec<f64>], frequency: f64) -> f64 {
    let length = sequences[0].len();
    let tau = std::f64::consts::TAU;
    let wave: Vec<(f64, f64)> = (0..length)
        .map(|i| {
            let window = 0.5 - 0.5 * (tau * i as f64 / length as f64).cos();
            let (sin, cos) = (tau * frequency * i as f64).sin_cos();
            (window * cos, window * sin)
        })
        .collect();
    let of_one = |sequence: &Vec<f64>| {
        let (re, im) =
            sequence.iter().zip(&wave).fold((0.0, 0.0), |(re, im), (x, (cos, sin))| (re + x * cos, im + x * sin));
        re * re + im * im
    };
    sequences.iter().map(of_one).sum::<f64>() / sequences.len() as f64
}

/// Slope of log power over log frequency, by least squares, and the standard deviation of it for powers that are means
/// of as many exponentially distributed numbers as there are sequences.
fn spectral_slope(sequences: &[Vec<f64>], frequencies: &[f64]) -> (f64, f64) {
    let points: Vec<(f64, f64)> = frequencies.iter().map(|&f| (f.ln(), power(sequences, f).ln())).collect();
    let n = points.len() as f64;
    let mean = points.iter().map(|p| p.0).sum::<f64>() / n;
    let squares: f64 = points.iter().map(|p| (p.0 - mean).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0 - mean) * p.1).sum::<f64>() / squares;
    (slope, (1.0 / (sequences.len() as f64 * squares)).sqrt())
}

/// Whole numbers of periods in the sequence, far enough apart for the window, from the tenth on.
fn frequencies(length: usize, count: i32) -> Vec<f64> {
    let last = length as f64 / 2.5;
    (0..count)
        .map(|i| 10.0 * (last / 10.0).powf(f64::from(i) / f64::from(count - 1)))
        .map(|k| k.round() / length as f64)
        .collect()
}

#[test]
fn flicker_noise_of_columns_falls_with_frequency_as_stated() {
    let mut sensor = quiet_sensor();
    let (width, height) = (1024, 2048);
    for exponent in [0.7, 1.0, 1.5] {
        sensor.noise.flicker = Flicker { noise: Electrons(1000.0), exponent, order: FlickerOrder::ColumnParallel };
        let noise = noise(&sensor, [width, height], 20_000.0, &[Stage::Flicker], 0);
        let columns: Vec<Vec<f64>> = (0..width).map(|x| noise[x..].iter().step_by(width).copied().collect()).collect();
        let (slope, sigma) = spectral_slope(&columns, &frequencies(height, 24));
        assert!((-slope / exponent - 1.0).abs() < 0.03, "{slope} ± {sigma} for −{exponent}");
        assert!(4.0 * sigma < 0.03 * exponent, "the test is sharp enough: {sigma}");
        // Columns know nothing of each other, so every row is a sample of 1024 independent numbers of variance σ². Rows
        // are alike, though, so that only so many count: 5 σ of √(2/1024).
        let variance = noise.chunks(width).map(|row| row.iter().map(|x| x * x).sum::<f64>()).sum::<f64>();
        let ratio = variance / noise.len() as f64 / 1e6;
        assert!((ratio - 1.0).abs() < 5.0 * (2.0 / width as f64).sqrt(), "{ratio}");
    }
}

#[test]
fn flicker_noise_of_a_serial_read_out_goes_on_from_row_to_row() {
    let mut sensor = quiet_sensor();
    sensor.noise.flicker = Flicker { noise: Electrons(1000.0), exponent: 1.0, order: FlickerOrder::Serial };
    let frames: Vec<Vec<f64>> =
        (0..100).map(|frame| noise(&sensor, [128, 128], 20_000.0, &[Stage::Flicker], frame)).collect();
    let (slope, sigma) = spectral_slope(&frames, &frequencies(128 * 128, 60));
    assert!((-slope - 1.0).abs() < 0.03, "{slope} ± {sigma}");
    assert!(4.0 * sigma < 0.03, "the test is sharp enough: {sigma}");
}

#[test]
fn telegraph_signals_stay_on_their_levels_for_the_stated_times() {
    let mut sensor = quiet_sensor();
    let (high, low, interval) = (0.9, 0.35, 0.1);
    sensor.noise.telegraph =
        TelegraphSignal { pixels: 1.0, amplitude: Electrons(3000.0), high: Seconds(high), low: Seconds(low) };
    let exposure = Exposure { time: Seconds(0.02), frame_interval: Some(Seconds(interval)), ..EXPOSURE };
    let light = flat(&sensor, 256, 128, 30_000.0);
    let levels = |frame| -> Vec<i32> {
        let key = NoiseKey { seed: 8, frame };
        let raw = expose(&light, &sensor, &exposure, Stages::only(&[Stage::Telegraph]), key).expect("valid");
        raw.data.iter().map(|&dn| (i32::from(dn) - 31_000).signum()).collect()
    };
    // Frames far from the first, in no order: the signal is known at any time.
    for first in [5000, 0, 77] {
        let frames: Vec<Vec<i32>> = (0..40).map(|k| levels(first + k)).collect();
        let (mut at_high, mut at_low, mut falls, mut rises) = (0.0, 0.0, 0.0, 0.0);
        for pair in frames.windows(2) {
            // Amplitudes that round to nothing have no levels.
            for (a, b) in pair[0].iter().zip(&pair[1]).filter(|(a, b)| **a != 0 && **b != 0) {
                match (a, b) {
                    (1, 1) => at_high += 1.0,
                    (-1, -1) => at_low += 1.0,
                    (1, _) => (at_high, falls) = (at_high + 1.0, falls + 1.0),
                    _ => (at_low, rises) = (at_low + 1.0, rises + 1.0),
                }
            }
        }
        let (fall, rise): (f64, f64) = (falls / at_high, rises / at_low);
        // Sampled at intervals Δ: P(fall) = (1 − d)(1 − e^(−νΔ)), P(rise) = d·(1 − e^(−νΔ)), ν = 1/τ_high + 1/τ_low.
        let rate = -(1.0 - fall - rise).ln() / interval;
        let measured = [(fall + rise) / (rate * fall), (fall + rise) / (rate * rise)];
        // 1.2 million pairs, of which some 10 % are changes: 120 000 counts are good to 0.3 %, amplified by less than
        // 2.
        assert!((measured[0] / high - 1.0).abs() < 0.03, "{measured:?}");
        assert!((measured[1] / low - 1.0).abs() < 0.03, "{measured:?}");
        let duty = at_high / (at_high + at_low);
        assert!((duty - high / (high + low)).abs() < 0.01, "{duty}");
    }
    // Times on a level are exponentially distributed: the correlation after n intervals is the n-th power of that after
    // one. Correlations of 33 000 pixels in a state of their own are good to 1/√33000; 5 σ.
    let frames = [0, 1, 3].map(levels);
    let correlation = |other: &[i32]| {
        let d = high / (high + low);
        let centred = |s: &i32| f64::from(u8::from(*s > 0)) - d;
        frames[0].iter().zip(other).map(|(a, b)| centred(a) * centred(b)).sum::<f64>()
            / other.len() as f64
            / (d * (1.0 - d))
    };
    for (frame, n) in [(1, 1.0), (2, 3.0)] {
        let expected = (-(1.0 / high + 1.0 / low) * interval * n).exp();
        let found = correlation(&frames[frame]);
        assert!((found - expected).abs() < 5.0 / 32_768f64.sqrt(), "{found} for {expected}");
    }
}

#[test]
fn telegraph_amplitudes_are_exponentially_distributed_and_few_pixels_have_them() {
    let mut sensor = quiet_sensor();
    sensor.noise.telegraph =
        TelegraphSignal { pixels: 0.05, amplitude: Electrons(1000.0), high: Seconds(1.0), low: Seconds(1.0) };
    let noise = noise(&sensor, [1024, 512], 30_000.0, &[Stage::Telegraph], 3);
    let jumping: Vec<f64> = noise.iter().filter(|x| x.abs() > 0.5).map(|x| 2.0 * x.abs()).collect();
    let n = noise.len() as f64;
    // Amplitudes below 1 round to nothing: 0.1 %. Binomial, 5 σ.
    assert!((jumping.len() as f64 / n - 0.05).abs() < 5.0 * (0.05 / n).sqrt() + 1e-4, "{}", jumping.len());
    let m = moments(&jumping);
    // Of an exponential distribution, mean and deviation are the same; 5 σ of 1/√26000 and of √(8/4/26000).
    assert!((m.mean() / 1000.0 - 1.0).abs() < 0.032, "{}", m.mean());
    assert!((m.variance().sqrt() / 1000.0 - 1.0).abs() < 0.045, "{}", m.variance());
}

#[test]
fn transmission_errors_are_black_or_white_and_elsewhere_in_every_image() {
    let mut sensor = quiet_sensor();
    sensor.noise.transmission_errors = 0.01;
    let [a, b] = [0, 1].map(|frame| noise(&sensor, [512, 512], 4000.0, &[Stage::TransmissionErrors], frame));
    let n = a.len() as f64;
    let [pepper, salt] = [-5000.0, 60_535.0].map(|value| a.iter().filter(|x| **x == value).count() as f64);
    let whole = a.iter().filter(|x| **x == 0.0).count() as f64;
    assert_eq!(pepper + salt + whole, n);
    // Binomial, 5 σ.
    assert!((salt / n - 0.005).abs() < 5.0 * (0.005 / n).sqrt(), "{salt}");
    assert!((pepper / n - 0.005).abs() < 5.0 * (0.005 / n).sqrt(), "{pepper}");
    let both = a.iter().zip(&b).filter(|(a, b)| **a != 0.0 && **b != 0.0).count() as f64;
    assert!((both / n - 1e-4).abs() < 5.0 * (1e-4 / n).sqrt(), "{both}");
}

#[test]
fn all_noise_together_is_what_the_model_foretells() {
    let mut sensor = noisy_sensor();
    sensor.full_well = Electrons(60_000.0);
    // These have no useful variance, or bend it.
    sensor.noise.transmission_errors = 0.0;
    sensor.noise.defects.stuck = 0.0;
    sensor.noise.defects.dead = 0.0;
    sensor.converter.amplifier_nonlinearity.clear();
    sensor.converter.column_gain = 0.0;
    sensor.converter.inl_dn = 0.0;
    // Fourth moments of heavy tails converge too slowly for a test.
    sensor.noise.read_degrees_of_freedom = Some(30.0);
    let exposure = Exposure { frame_interval: Some(Seconds(50.0)), temperature: Celsius(30.0), ..EXPOSURE };
    let light = flat(&sensor, 512, 512, 500.0);
    let image =
        |frame| expose(&light, &sensor, &exposure, Stages::ALL, NoiseKey { seed: 5, frame }).expect("valid").data;
    // Row, column and flicker noise are shared, so that few numbers count in one image; many images tell.
    let frames: Vec<Vec<u16>> = (0..24).map(image).collect();
    let differences = frames.chunks(2).flat_map(|pair| pair[0].iter().zip(&pair[1]));
    let m: Moments = differences.map(|(&a, &b)| f64::from(a) - f64::from(b)).collect();
    let predicted = sensor.noise_variance(Electrons(500.0), &exposure);
    // Row and column noise, 400 + 900 of some 6000 (e⁻)², are known to √(2/(12·512)) = 1.8 %, flicker's 625 no better;
    // together 0.35 % of the sum. TelegraphSignal signals, 0.1·2·2500·2/9 = 111 with heavy tails, add less. 5 σ.
    assert!((m.variance() / 2.0 / predicted - 1.0).abs() < 0.0175, "{} for {predicted}", m.variance() / 2.0);
}
