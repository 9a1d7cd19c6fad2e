//! From light to electrons by hand, and to an exposure time.

use photosite::image::Planes;
use photosite::math::statistics::Moments;
use photosite::sensor::{
    AutoExposure, Exposure, Metering, NoiseKey, Stage, Stages, TimeLimit, auto_exposure, expose, presets,
};
use photosite::spectrum::Spectrum;
use photosite::units::{Decibels, Electrons, Seconds};

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
        // A ramp of rates, bright enough for times that scanning sensors allow, and one pixel in 400 that shines far
        // brighter.
        let (width, height) = (100, 80);
        let mut rates = Planes::zeros(width, height, sensor.cfa.channels());
        for channel in rates.channels_mut() {
            for (i, rate) in channel.data.iter_mut().enumerate() {
                *rate = if i % 400 == 0 { 1e12 } else { 1e6 * i as f32 };
            }
        }
        let metering = Metering::Highlights { brighter_part: 0.01, level: 0.8 };
        let target = AutoExposure { metering, ..AutoExposure::default() };
        let [least, most] = sensor.converter.gain_range;
        let wanted = Exposure { gain: Decibels(6.0f64.clamp(least.0, most.0)), ..EXPOSURE };
        let exposure = auto_exposure(&rates, Seconds(1.0), &sensor, &wanted, target).expect("there is light").exposure;
        let raw = expose(&rates.scaled(exposure.time.0), &sensor, &exposure, Stages::NONE, NoiseKey::default())
            .expect("valid");
        let numbers = raw.cropped().data;
        let saturation = sensor.saturation_capacity(&exposure).0 * sensor.system_gain(&exposure);
        let level = f64::from(raw.black_level_dn.mean()) + 0.8 * saturation;
        // The dark current, which is left out here, is less than a DN of it.
        let brighter = numbers.iter().filter(|&&dn| f64::from(dn) > level + 1.0).count();
        let close = numbers.iter().filter(|&&dn| f64::from(dn) > level - 0.01 * saturation).count();
        assert!(brighter <= numbers.len() / 100, "{name}: {brighter} pixels above the level");
        assert!(close >= numbers.len() / 100, "{name}: {close} pixels at the level");
    }
}

#[test]
fn sensors_that_scan_are_exposed_for_a_line_time_at_most() {
    let sensor = presets::model("generic-line-scan").expect("a preset");
    let rates = flat(&sensor, 64, 4, 10.0);
    let found = auto_exposure(&rates, Seconds(1.0), &sensor, &EXPOSURE, AutoExposure::default())
        .expect("there is light")
        .exposure;
    assert_eq!(found.time, sensor.shutter.row_time());
    let said =
        auto_exposure(&rates, Seconds(1.0), &sensor, &EXPOSURE, AutoExposure::default()).expect("there is light");
    assert_eq!(said.limit, Some(TimeLimit::Line));
    // 10 e⁻/s in a line time, and the dark current, are next to nothing of what saturates.
    assert!(said.brightness < 1e-3 && said.warning().is_some_and(|text| text.contains("sensor.shutter.row_time_us")));
    found.validate(&sensor).expect("what the sensor can do");
}

#[test]
fn black_images_have_no_exposure_time() {
    let sensor = quiet_sensor();
    for metering in [Metering::default(), Metering::Mean(0.2)] {
        let target = AutoExposure { metering, ..AutoExposure::default() };
        for rates in [flat(&sensor, 8, 8, 0.0), flat(&sensor, 0, 0, 0.0)] {
            assert!(auto_exposure(&rates, Seconds(1.0), &sensor, &EXPOSURE, target).is_err());
        }
    }
    assert_eq!(sensor.saturation_capacity(&EXPOSURE), Electrons(60_000.0));
}

#[test]
fn metering_the_mean_counts_saturated_pixels_as_saturated() {
    let sensor = quiet_sensor();
    // 10 % of the pixels are lamps, the others a ramp.
    let rate = |i: usize| if i.is_multiple_of(10) { 1e8 } else { i as f32 };
    let mut rates = flat(&sensor, 50, 40, 0.0);
    for (i, to) in rates.channels_mut()[0].data.iter_mut().enumerate() {
        *to = rate(i);
    }
    for level in [0.1001, 0.18, 0.5, 0.9] {
        let target = AutoExposure { metering: Metering::Mean(level), ..AutoExposure::default() };
        let exposure =
            auto_exposure(&rates, Seconds(1.0), &sensor, &EXPOSURE, target).expect("there is light").exposure;
        let light = rates.clone().scaled(exposure.time.0);
        let raw = expose(&light, &sensor, &exposure, Stages::only(&[Stage::FullWell]), NoiseKey::default());
        let mean = raw.expect("valid").data.iter().map(|&dn| f64::from(dn) - 1000.0).sum::<f64>() / 2000.0;
        // Numbers are rounded, by up to half a DN of 60 000.
        assert!((mean / 60_000.0 - level).abs() < 1e-5, "{mean} for {level}");
    }
    // An image of which half is black never gets brighter than the other half.
    for (i, to) in rates.channels_mut()[0].data.iter_mut().enumerate() {
        *to = if i < 1000 { 0.0 } else { 5.0 };
    }
    let target = AutoExposure { metering: Metering::Mean(0.6), ..AutoExposure::default() };
    assert!(auto_exposure(&rates, Seconds(1.0), &sensor, &EXPOSURE, target).is_err());
}

#[test]
fn gain_rises_where_time_may_not() {
    let sensor = quiet_sensor();
    let rates = flat(&sensor, 8, 8, 1000.0);
    // To 0.5 of 60 000 e⁻ takes 30 s.
    let max_gain = Some(Decibels(40.0));
    let target = AutoExposure { metering: Metering::Mean(0.5), max_gain, ..AutoExposure::default() };
    let found = |max_time: f64, target: AutoExposure| {
        let target = AutoExposure { max_time: Some(Seconds(max_time)), ..target };
        auto_exposure(&rates, Seconds(1.0), &sensor, &EXPOSURE, target).expect("there is light").exposure
    };
    let free = found(100.0, target);
    assert!((free.time.0 - 30.0).abs() < 1e-9 && free.gain == Decibels(0.0));
    // Half a range of 64 535 DN at a gain that leaves 2·1000·t of it; the analogue gain ends at 24 dB.
    for (time, factor) in [(15.0, 64_535.0 / 30_000.0), (3.0, 64_535.0 / 6000.0), (0.5, 64_535.0 / 1000.0)] {
        let limited = found(time, target);
        let total = limited.gain.factor() * limited.digital_gain.factor();
        assert!((total / factor - 1.0).abs() < 1e-9 && limited.time == Seconds(time), "{limited:?}");
        assert_eq!(limited.digital_gain.0 > 0.0, factor > Decibels(24.0).factor());
        let raw = expose(&rates.clone().scaled(time), &sensor, &limited, Stages::NONE, NoiseKey::default());
        let level = (f64::from(raw.expect("valid").data[0]) - 1000.0) / 64_535.0;
        // A DN of the converter, times the digital gain, which is below 10.
        assert!((level - 0.5).abs() < 10.0 / 64_535.0, "{level} at {time} s");
    }
    let most = found(1e-3, target);
    assert_eq!((most.gain, most.digital_gain), (Decibels(24.0), Decibels(16.0)));
    let fixed = found(1e-3, AutoExposure { max_gain: None, ..target });
    assert_eq!(fixed, Exposure { time: Seconds(1e-3), ..EXPOSURE });
}

#[test]
fn digital_gain_shows_in_the_noise_and_its_rounding() {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.read = Electrons(3.0));
    for (gain_db, digital_gain_db) in [(0.0, 6.0), (6.0, 6.0), (0.0, 20.0 * 2f64.log10()), (0.0, 13.3)] {
        let gains = (Decibels(gain_db), Decibels(digital_gain_db));
        let exposure = Exposure { gain: gains.0, digital_gain: gains.1, ..EXPOSURE };
        let raw = expose(&flat(&sensor, 512, 512, 400.0), &sensor, &exposure, Stages::ALL, NoiseKey::default());
        let raw = raw.expect("valid");
        let numbers: Moments = raw.data.iter().map(|&dn| f64::from(dn) - 1000.0).collect();
        let gain = sensor.system_gain(&exposure);
        let (mean, variance) = (400.0 * gain, sensor.noise_variance(Electrons(400.0), &exposure) * gain * gain);
        let n = 512.0 * 512.0;
        // 5 σ of mean and variance; halves that are rounded up add up to half a DN to the mean.
        assert!((numbers.mean() - mean).abs() < 5.0 * (variance / n).sqrt() + 0.5, "{} for {mean}", numbers.mean());
        let ratio = numbers.variance() / variance;
        assert!((ratio - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{ratio} at {digital_gain_db} dB");
        // The raw file says the same of its noise.
        let range = f64::from(raw.white_level_dn) - 1000.0;
        let [slope, offset] = raw.metadata.noise_profile[0];
        let stated = (slope * mean / range + offset) * range * range;
        assert!((stated / variance - 1.0).abs() < 1e-9, "{stated} for {variance}");
    }
}
