//! From the pixels to numbers: bandwidth, samples of a frame grabber, few levels.

use photosite::characterisation::OperatingPoint;
use photosite::image::{Channel, Planes};
use photosite::raw::Cfa;
use photosite::sensor::{
    Exposure, FrameGrabber, LowPass, NoiseKey, NoiseMap, SensorModel, SignalInterpolation, Stage, Stages, VideoCurve,
    expose, expose_with_maps,
};
use photosite::spectrum::Spectrum;
use photosite::units::{Celsius, Decibels, Electrons};
use rstest::rstest;

use crate::sensor_cases::{EXPOSURE, flat, quiet_sensor};

const SIDE: usize = 512;

fn narrow(missing: f64) -> SensorModel {
    let mut sensor = quiet_sensor();
    sensor.video.low_pass = Some(LowPass { missing });
    sensor
}

/// Mean, variance and autocovariance along rows over the variance, for distances of 0 to 8 pixels.
fn along_rows(data: &[u16], width: usize) -> (f64, f64, Vec<f64>) {
    let mean = data.iter().map(|&dn| f64::from(dn)).sum::<f64>() / data.len() as f64;
    let covariance = |k: usize| {
        let pairs = data.chunks(width).flat_map(|row| row.iter().zip(&row[k..]));
        let count = data.len() / width * (width - k);
        pairs.map(|(&a, &b)| (f64::from(a) - mean) * (f64::from(b) - mean)).sum::<f64>() / count as f64
    };
    let variance = covariance(0);
    (mean, variance, (0..=8).map(|k| covariance(k) / variance).collect())
}

/// White noise behind a low pass of the first order is autoregressive: ρ(k) = a^k, and (1 − a)/(1 + a) of its variance.
#[rstest]
fn noise_goes_along_rows_as_the_closed_form_says(#[values(0.05, 0.3, 0.7)] missing: f64) {
    let mean_e = 20_000.0;
    let sensor = narrow(missing);
    let raw = expose(&flat(&sensor, SIDE, SIDE, mean_e), &sensor, &EXPOSURE, Stages::ALL, NoiseKey::default());
    let raw = raw.expect("valid");
    let (mean, variance, rho) = along_rows(&raw.data, SIDE);
    let left = (1.0 - missing) / (1.0 + missing);
    let pixels = (SIDE * SIDE) as f64;
    // Of N pixels of which (1 + a²)/(1 − a²) count as one, the variance is good to √2 of that; rounding adds 1/12. The
    // first pixels of rows, which begin settled, have more: a² + a⁴ + … of them in 512.
    let independent = pixels * (1.0 - missing * missing) / (1.0 + missing * missing);
    let start = missing * missing / (1.0 - missing * missing) / SIDE as f64 / left;
    let expected = left * f64::from(mean_e) + 1.0 / 12.0;
    assert!((variance / expected - 1.0).abs() < 5.0 * (2.0 / independent).sqrt() + start, "{variance} for {expected}");
    assert!((mean - 1000.0 - f64::from(mean_e)).abs() < 5.0 * (f64::from(mean_e) / pixels).sqrt());
    for (k, rho) in rho.iter().enumerate().skip(1) {
        // Bartlett: the variance of ρ(k) is below (1 + a²)/(1 − a²)/N.
        let bound = 5.0 / independent.sqrt() + start;
        assert!((rho - missing.powi(k as i32)).abs() < bound, "ρ({k}) = {rho}");
    }
    // What the file says of the noise, for the normalised signal.
    let [slope, offset] = raw.metadata.noise_profile[0];
    let range = f64::from(raw.white_level_dn) - 1000.0;
    let stated = (slope * f64::from(mean_e) / range + offset) * range * range;
    assert!((stated / (left * (f64::from(mean_e) + 1.0 / 12.0)) - 1.0).abs() < 1e-9, "{stated}");
    // Columns are as they were.
    let columns: Vec<u16> = (0..SIDE).flat_map(|x| raw.data.iter().skip(x).step_by(SIDE).copied()).collect();
    let (_, _, down) = along_rows(&columns, SIDE);
    assert!(down[1].abs() < 5.0 / independent.sqrt());
}

#[test]
fn noise_behind_the_line_is_not_shared_by_neighbours() {
    let mut sensor = narrow(0.6);
    sensor.converter =
        photosite::sensor::Converter { bits: 6, conversion_gain_dn_per_e: 63.0 / 20_000.0, ..sensor.converter };
    sensor.converter.black_level = 0.into();
    // A ramp that takes all parts of a step in turn: rounding is the only noise.
    let data: Vec<f32> = (0..SIDE * SIDE).map(|i| 10_000.0 + (i % 997) as f32 * 3.7).collect();
    let planes = Planes::new(SIDE, SIDE, vec![Channel { name: "Y".to_owned(), data }]).expect("right sizes");
    let raw = expose(&planes, &sensor, &EXPOSURE, Stages::NONE.with(Stage::VideoBandwidth), NoiseKey::default());
    assert!(raw.expect("valid").data.iter().all(|&dn| dn < 64));
}

/// EMVA 1288 asks for pixels that are alike, linear and independent.
#[test]
fn photon_transfer_is_refused_by_the_key_that_spoils_it() {
    let point = OperatingPoint { channel: 0, wavelength_nm: 550.0, gain: Decibels(0.0), temperature: Celsius(25.0) };
    let refused = |change: fn(&mut SensorModel)| {
        let mut sensor = quiet_sensor();
        change(&mut sensor);
        point.validate(&sensor).expect_err("not as the standard wants it").key
    };
    assert_eq!(refused(|s| s.video.curve = Some(VideoCurve { gamma: 2.0, range_dn: 1000.0 })), "video.gamma");
    assert_eq!(refused(|s| s.video.low_pass = Some(LowPass { missing: 0.1 })), "video.bandwidth_mhz");
    let grabber = |s: &mut SensorModel| {
        s.frame_grabber = Some(FrameGrabber { size: [8, 8], interpolation: SignalInterpolation::Linear });
    };
    assert_eq!(refused(grabber), "frame_grabber");
    let circle = |s: &mut SensorModel| {
        s.cells.image_circle = Some(photosite::cells::ImageCircle::new(1.0, s.resolution, s.pixel_pitch_m));
    };
    assert_eq!(refused(circle), "image_circle_mm");
    assert!(point.validate(&quiet_sensor()).is_ok());
}

/// A ramp over all of the range has the error q²/12 whatever the number of levels, half steps at both ends included.
#[rstest]
fn few_levels_have_the_error_of_their_steps(#[values(16, 8, 6, 3, 1)] bits: u32) {
    let mut sensor = quiet_sensor();
    let (range_e, levels) = (60_000.0, f64::from(1u32 << bits));
    let step = range_e / (levels - 1.0);
    sensor.converter.bits = bits;
    sensor.converter.black_level = 0.into();
    sensor.converter.conversion_gain_dn_per_e = 1.0 / step;
    sensor.full_well = Electrons(1e9);
    let count = 240_000;
    let data: Vec<f32> = (0..count).map(|i| (range_e * (f64::from(i) + 0.5) / f64::from(count)) as f32).collect();
    let planes =
        Planes::new(600, 400, vec![Channel { name: "Y".to_owned(), data: data.clone() }]).expect("right sizes");
    let raw = expose(&planes, &sensor, &EXPOSURE, Stages::NONE, NoiseKey::default()).expect("valid");
    let square = |(&dn, &e): (&u16, &f32)| (f64::from(dn) * step - f64::from(e)).powi(2);
    let mean_square = raw.data.iter().zip(&data).map(square).sum::<f64>() / f64::from(count);
    // Of steps of 4 or more of the ramp's steps, one of them is not seen whole: (1/n)², and f32 has 2⁻²⁴ of 60 000.
    let steps = f64::from(count) * step / range_e;
    assert!((mean_square / (step * step / 12.0) - 1.0).abs() < 2.0 / (steps * steps) + 0.01, "{mean_square}");
    assert_eq!(
        (raw.bits, raw.white_level_dn, raw.data.iter().max()),
        (bits, (levels - 1.0) as u16, Some(&raw.white_level_dn))
    );
}

/// Maps of what stages do are sampled as the image is, and still sum to its numbers.
#[rstest]
fn maps_sum_to_the_samples_of_a_frame_grabber(
    #[values(SignalInterpolation::Nearest, SignalInterpolation::Linear)] interpolation: SignalInterpolation,
    #[values("mono", "full:RGB")] cfa: &str,
) {
    let mut sensor = narrow(0.3);
    sensor.cfa = Cfa::parse(cfa).expect("known");
    sensor.quantum_efficiency = vec![Spectrum::constant(0.5); sensor.cfa.channels().len()];
    sensor.masked.columns = [3, 2];
    sensor.masked.rows = [1, 4];
    sensor.noise.read_out.change(|noise| noise.read = Electrons(40.0));
    sensor.video.curve = Some(VideoCurve { gamma: 0.45, range_dn: 64_535.0 });
    sensor.frame_grabber = Some(FrameGrabber { size: [50, 30], interpolation });
    let exposure = Exposure { gain: Decibels(6.0), ..EXPOSURE };
    let light = flat(&sensor, 40, 36, 5000.0);
    let (raw, maps) =
        expose_with_maps(&light, &sensor, &exposure, Stages::ALL, NoiseKey::default(), &NoiseMap::ALL).expect("valid");
    assert_eq!(([raw.width, raw.height], raw.active_area), ([50, 30], None));
    let pitch = raw.metadata.pixel_pitch_m.expect("known");
    assert!(
        [(0, 0.8), (1, 1.2)]
            .iter()
            .all(|&(axis, n)| (pitch[axis] / sensor.pixel_pitch_m[axis] / n - 1.0).abs() < 1e-12)
    );
    let samples = sensor.cfa.samples_per_pixel();
    for (i, &dn) in raw.data.iter().enumerate() {
        let sum: f64 = NoiseMap::ALL
            .into_iter()
            .zip(maps.planes.channels().chunks(samples))
            .map(|(map, planes)| {
                let value = f64::from(planes[i % samples].data[i / samples]);
                match map.unit() {
                    photosite::sensor::MapUnit::Electrons => value * maps.system_gain,
                    photosite::sensor::MapUnit::DigitalNumbers => value,
                    photosite::sensor::MapUnit::None => 0.0,
                }
            })
            .sum();
        // Some forty sums of f32 of up to 65 535.
        assert!((sum + maps.black_level_dn - f64::from(dn)).abs() < 0.2, "{i}: {sum} for {dn}");
    }
}
