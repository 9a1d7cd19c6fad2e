//! Every stage of the sensor at any light, alone and beside all others, up to a million times what a pixel holds: numbers
//! are those of the converter, what is recorded is finite, and signals do not fall as light rises.
//!
//! The tables are drawn from [`Stage`] and [`NoiseMap`]: a new effect takes part, or does not compile.

use photosite::image::Planes;
use photosite::math::statistics::Moments;
use photosite::raw::RawImage;
use photosite::sensor::{
    Binning, BinningMethod, Companding, CompandingCurve, Exposure, Logarithmic, NoiseKey, NoiseMap, RegionOfInterest,
    SensorModel, Shutter, Stage, Stages, VideoCurve, expose_after, expose_with_maps, presets,
};
use photosite::units::{Celsius, Decibels, Seconds};
use rstest::rstest;

use crate::sensor_cases::{EXPOSURE, flat, noisy_sensor, noisy_sensor_with};

const SIZE: [usize; 2] = [32, 24];
const KEY: NoiseKey = NoiseKey { seed: 3, frame: 1 };
/// Light, in full wells.
const LEVELS: [f64; 6] = [0.0, 0.5, 1.0, 30.0, 1e3, 1e6];

/// Where light falls.
#[derive(Clone, Copy, Debug)]
enum Irradiation {
    Everywhere,
    OnePixel,
}

impl Irradiation {
    fn planes(self, sensor: &SensorModel, mean_e: f64) -> Planes {
        let [width, height] = SIZE;
        match self {
            Self::Everywhere => flat(sensor, width, height, mean_e as f32),
            Self::OnePixel => {
                let mut planes = flat(sensor, width, height, 0.0);
                let middle = height / 2 * width + width / 2;
                planes.channels_mut().iter_mut().for_each(|channel| channel.data[middle] = mean_e as f32);
                planes
            }
        }
    }
}

/// A sensor on which an effect shows at some light, and how it is exposed.
fn showing(map: NoiseMap) -> (SensorModel, Exposure) {
    let (mut sensor, mut exposure) = (noisy_sensor(), EXPOSURE);
    match map {
        NoiseMap::BrighterFatterE => sensor = noisy_sensor_with(Stage::BrighterFatter),
        NoiseMap::SmearE => sensor = noisy_sensor_with(Stage::Smear),
        NoiseMap::BloomingE => sensor = noisy_sensor_with(Stage::Blooming),
        NoiseMap::ChargeTransferE => sensor = noisy_sensor_with(Stage::VerticalTransfer),
        NoiseMap::PhotonCountingE => sensor = noisy_sensor_with(Stage::PhotonCounting),
        NoiseMap::ImageLagE => sensor = noisy_sensor_with(Stage::ImageLag),
        NoiseMap::VideoBandwidthDn => sensor = noisy_sensor_with(Stage::VideoBandwidth),
        NoiseMap::LogarithmicResponseE => sensor.logarithmic = Some(Logarithmic { reference_e_per_s: 500.0 }),
        NoiseMap::VideoCurveDn => sensor.video.curve = Some(VideoCurve { gamma: 0.45, range_dn: 2450.0 }),
        NoiseMap::ClippingDn => (sensor.converter.bits, exposure.gain) = (15, Decibels(24.0)),
        NoiseMap::RoundingDn => {
            let binning = Binning { factor: [2, 2], method: BinningMethod::Sum };
            exposure.region = RegionOfInterest { binning, pixels: None };
            exposure.digital_gain = Decibels(5.0);
        }
        NoiseMap::CompandingDn => {
            let curve = CompandingCurve::KneePoints(vec![[0, 0], [2048, 2048], [65_535, 4095]]);
            sensor.converter.companding = Some(Companding { bits: 12, curve });
        }
        NoiseMap::CrosstalkE
        | NoiseMap::PhotoElectronsE
        | NoiseMap::PrnuE
        | NoiseMap::DeadPixelsE
        | NoiseMap::PhotonShotNoiseE
        | NoiseMap::DarkCurrentE
        | NoiseMap::DarkCurrentNonuniformityE
        | NoiseMap::DarkShotNoiseE
        | NoiseMap::HotPixelsE
        | NoiseMap::FullWellE
        | NoiseMap::FlickerNoiseE
        | NoiseMap::ResetNoiseE
        | NoiseMap::TelegraphNoiseE
        | NoiseMap::DsnuE
        | NoiseMap::RowNoiseE
        | NoiseMap::ColumnNoiseE
        | NoiseMap::AmplifierNonlinearityE
        | NoiseMap::ReadNoiseE
        | NoiseMap::ColumnAmplifiersDn
        | NoiseMap::AdcNonlinearityDn
        | NoiseMap::QuantisationDn
        | NoiseMap::StuckPixelsDn
        | NoiseMap::TransmissionErrorsDn
        | NoiseMap::PrnuGain
        | NoiseMap::Saturated
        | NoiseMap::RawClean => {}
    }
    (sensor, exposure)
}

/// Whether what a stage does is drawn anew for other light, so that pixels rise on average only; so do numbers that arrive
/// with other bits.
fn is_drawn(stage: Stage) -> bool {
    use Stage::{HorizontalTransfer, PhotonCounting, ShotNoise, TransmissionErrors, VerticalTransfer};
    [ShotNoise, PhotonCounting, VerticalTransfer, HorizontalTransfer, TransmissionErrors].contains(&stage)
}

/// Exposes to each of the [`LEVELS`] in turn, and checks the numbers and what is recorded of them.
fn exposed(
    sensor: &SensorModel,
    exposure: &Exposure,
    stages: Stages,
    lit: Irradiation,
    maps: &[NoiseMap],
) -> Vec<RawImage> {
    let run = |level: f64| {
        let light = lit.planes(sensor, level * sensor.full_well.0);
        let (raw, found) = expose_with_maps(&light, sensor, exposure, stages, KEY, maps).expect("a valid exposure");
        let most = u32::MAX >> (32 - raw.bits);
        assert!(raw.data.iter().all(|&dn| u32::from(dn) <= most), "{level} × {lit:?}: beyond {most} DN");
        for channel in found.planes.channels() {
            assert!(channel.data.iter().all(|v| v.is_finite()), "{level} × {lit:?}: {} is not finite", channel.name);
        }
        raw
    };
    LEVELS.map(run).into()
}

/// Each image has no less signal than the one before, which had less light: the mean of the differences, to 5 of its
/// standard deviations.
fn assert_rises_on_average(images: &[RawImage], case: &dyn std::fmt::Debug) {
    for (level, pair) in LEVELS[1..].iter().zip(images.windows(2)) {
        let difference = |(a, b): (&u16, &u16)| f64::from(*b) - f64::from(*a);
        let differences: Moments = pair[0].data.iter().zip(&pair[1].data).map(difference).collect();
        let deviation = (differences.variance() / pair[0].data.len() as f64).sqrt();
        assert!(differences.mean() >= -5.0 * deviation, "{case:?} {level}: {} ± {deviation}", differences.mean());
    }
}

#[rstest]
fn a_stage_alone_lets_every_pixel_rise(#[values(Irradiation::Everywhere, Irradiation::OnePixel)] lit: Irradiation) {
    for stage in Stage::ALL {
        let sensor = noisy_sensor_with(stage);
        let images = exposed(&sensor, &EXPOSURE, Stages::only(&[stage]), lit, &NoiseMap::ALL);
        assert_rises_on_average(&images, &stage);
        if is_drawn(stage) {
            continue;
        }
        for (level, pair) in LEVELS[1..].iter().zip(images.windows(2)) {
            for (i, (before, after)) in pair[0].data.iter().zip(&pair[1].data).enumerate() {
                // Each is rounded once.
                assert!(
                    u32::from(*after) + 1 >= u32::from(*before),
                    "{stage:?} {lit:?} {level}, number {i}: {after} DN after {before}"
                );
            }
        }
    }
}

/// Test that stages before the full well cannot bring a pixel below black or above saturation.
#[rstest]
fn charge_ends_between_black_and_the_full_well(
    #[values(Irradiation::Everywhere, Irradiation::OnePixel)] lit: Irradiation,
) {
    for stage in Stage::ALL.into_iter().take_while(|stage| *stage != Stage::FullWell) {
        let sensor = noisy_sensor_with(stage);
        // The amplifiers, too, of which the white level knows.
        let stages = Stages::only(&[stage, Stage::FullWell, Stage::AmplifierNonlinearity]);
        for (level, raw) in LEVELS.iter().zip(exposed(&sensor, &EXPOSURE, stages, lit, &[])) {
            // Of two gains, the merged number of black is that of the converter's black level.
            let range = sensor.converter.black_level_dn(Default::default())..=raw.white_level_dn;
            assert!(raw.data.iter().all(|dn| range.contains(dn)), "{stage:?} {lit:?} {level}: beyond {range:?}");
        }
    }
}

#[rstest]
fn all_stages_together_let_signals_rise(#[values(Irradiation::Everywhere, Irradiation::OnePixel)] lit: Irradiation) {
    for map in NoiseMap::ALL {
        let (sensor, exposure) = showing(map);
        assert_rises_on_average(&exposed(&sensor, &exposure, Stages::ALL, lit, &NoiseMap::ALL), &map);
    }
}

#[test]
fn every_effect_shows_on_the_sensor_of_the_table() {
    for map in NoiseMap::ALL {
        let (sensor, exposure) = showing(map);
        let shows = |level: f64, lit: Irradiation| {
            let light = lit.planes(&sensor, level * sensor.full_well.0);
            let (_, found) = expose_with_maps(&light, &sensor, &exposure, Stages::ALL, KEY, &[map]).expect("valid");
            found.planes.channels()[0].data.iter().any(|&v| v != 0.0)
        };
        let at = |level: f64| shows(level, Irradiation::Everywhere) || shows(level, Irradiation::OnePixel);
        assert!(LEVELS.into_iter().any(at), "{map:?}");
    }
}

#[rstest]
fn presets_let_signals_rise(
    #[values(Irradiation::Everywhere, Irradiation::OnePixel)] lit: Irradiation,
    #[values(-100.0, 25.0, 80.0)] temperature_c: f64,
    #[values(1e-5, 1.0)] time_s: f64,
    #[values(0, 1)] highest_gain: usize,
) {
    for name in presets::names() {
        let sensor = SensorModel { shutter: Shutter::Global, ..presets::model(name).expect("listed") };
        let exposure = Exposure {
            gain: sensor.converter.gain_range[highest_gain],
            temperature: Celsius(temperature_c),
            ..Exposure::of(Seconds(time_s))
        };
        assert_rises_on_average(&exposed(&sensor, &exposure, Stages::ALL, lit, &NoiseMap::ALL), &name);
    }
}

/// A dark frame after each of the levels: what stays behind does not fall as light rises.
#[test]
fn frames_after_a_lamp_rise_with_it() {
    let sensor = noisy_sensor_with(Stage::ImageLag);
    let frame = |level: f64| {
        let exposed = |level: f64, number: u64, before: Option<&_>| {
            let light = Irradiation::OnePixel.planes(&sensor, level * sensor.full_well.0);
            let key = NoiseKey { frame: number, ..KEY };
            expose_after(&light, &sensor, &EXPOSURE, Stages::ALL, key, &[], before).expect("valid")
        };
        let lamp = exposed(level, 0, None);
        exposed(0.0, 1, lamp.left.as_ref()).raw
    };
    assert_rises_on_average(&LEVELS.map(frame), &"image lag");
}
