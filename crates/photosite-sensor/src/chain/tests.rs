//! Effects that a sensor has, and those that it has not, judged by its digital numbers.

use photosite_core::image::Planes;
use photosite_core::units::{Decibels, Electrons, Seconds};
use photosite_raw::RawImage;

use super::expose_with_maps;
use crate::{
    Binning, BinningMethod, Exposure, GainStepDescription, Noise, NoiseDescription, NoiseKey, NoiseMap,
    RegionOfInterest, SensorDescription, SensorModel, Stage, Stages, presets,
};

const SIZE: [usize; 2] = [96, 64];

/// Keys that give a sensor what no preset has, and the preset that they are laid over.
const OTHERS: [(&str, &str); 2] = [
    (
        "generic-cmos-color",
        "crosstalk = [[0.0, 0.05, 0.0], [0.05, 0.8, 0.05], [0.0, 0.05, 0.0]]\n\
         [noise]\nrow_noise_e = 3.0\ncolumn_noise_e = 3.0\nflicker.noise_e = 3.0\nreset.noise_e = 5.0\n\
         telegraph = { pixels_per_million = 50000.0, amplitude_e = 50.0 }\ntransmission_errors_per_million = 5000.0\n\
         dark_current_nonuniformity_percent = 50.0\n\
         [charge]\nbrighter_fatter_per_e = [3e-7, 3e-7]\nimage_lag.percent = 5.0\n\
         [adc]\namplifier_nonlinearity_percent = [-5.0]\ninl_dn = 3.0\ndnl_dn = 0.3\ncolumn_gain_percent = 2.0\n\
         column_offset_dn = 3.0\n\
         [defects]\ndead_per_million = 20000.0\nstuck_per_million = 20000.0\nhot_per_million = 20000.0\n\
         hot_dark_current_e_per_s = 1000.0\n",
    ),
    (
        "textbook-ccd",
        "[ccd]\nvertical_cti = 0.001\nhorizontal_cti = 0.001\narchitecture = \"interline\"\nsmear_db = -40.0\nline_time_us = 30.0\n\
         [video]\nbandwidth_mhz = 5.0\npixel_clock_mhz = 10.0\n",
    ),
];

/// Sensors: all presets, others, and one without noise.
pub(crate) fn sensors() -> Vec<SensorModel> {
    let other = |&(preset, text): &(&str, &str)| {
        let mut table = presets::table(preset).expect("a preset");
        for (key, value) in text.parse::<toml::Table>().expect("TOML") {
            match (table.get_mut(&key), value) {
                (Some(toml::Value::Table(known)), toml::Value::Table(new)) => known.extend(new),
                (_, value) => drop(table.insert(key, value)),
            }
        }
        let description: SensorDescription = table.try_into().expect("keys of a sensor");
        SensorModel::new(preset, &description, presets::library_spectrum).expect("a sensor")
    };
    let quiet = SensorModel { noise: Noise::NONE, ..presets::model(presets::DEFAULT).expect("a preset") };
    presets::names().filter_map(presets::model).chain(OTHERS.iter().map(other)).chain([quiet]).collect()
}

/// Light in stripes, from darkness on the left to three times the full well on the right.
fn light(sensor: &SensorModel) -> Planes {
    let [width, height] = SIZE;
    let mut planes = Planes::zeros(width, height, sensor.cfa.channels());
    let full_well = sensor.full_well.0 as f32;
    for channel in planes.channels_mut() {
        for (i, value) in channel.data.iter_mut().enumerate() {
            let (x, y) = (i % width, i / width);
            *value = if y / 8 % 2 == 0 { 3.0 * full_well * (x as f32 / width as f32).powi(3) } else { 0.0 };
        }
    }
    planes
}

#[test]
fn effects_that_a_sensor_has_not_change_nothing_and_the_others_do() {
    let key = NoiseKey { seed: 5, frame: 0 };
    let sensors = sensors();
    let mut changing = Stages::NONE;
    for sensor in &sensors {
        let light = light(sensor);
        // The lines of a scanning sensor follow each other.
        let exposure = Exposure::of(Seconds(if sensor.shutter.scans() { 1e-5 } else { 0.05 }));
        let expose = |stages, maps: &[NoiseMap]| {
            expose_with_maps(&light, sensor, &exposure, stages, key, maps).expect("an exposure")
        };
        let (raw, maps) = expose(Stages::ALL, &NoiseMap::ALL);
        for stage in Stage::ALL {
            let changes = expose(Stages::ALL.without(stage), &[]).0.data != raw.data;
            assert!(sensor.has_stage(stage) || !changes, "{} has {stage:?}", sensor.name);
            changing = if changes { changing.with(stage) } else { changing };
        }
        for map in NoiseMap::ALL.into_iter().filter(|&map| !sensor.has_map(map)) {
            let value = if map == NoiseMap::PrnuGain { 1.0 } else { 0.0 };
            for plane in maps.planes.channels().iter().filter(|plane| plane.name.split('.').next() == Some(map.name()))
            {
                assert!(plane.data.iter().all(|&v| v == value), "{} has {}", sensor.name, map.name());
            }
        }
    }
    // Each stage is seen to work in some sensor, and to be missing in another, but for those that all have.
    for stage in Stage::ALL {
        assert!(changing.has(stage), "{stage:?} changes no sensor here");
        let all_have = matches!(stage, Stage::ShotNoise | Stage::FullWell);
        assert_eq!(sensors.iter().all(|sensor| sensor.has_stage(stage)), all_have, "{stage:?}");
    }
}

/// Property: a sensor with steps of gain is at each gain the sensor whose noise is what the steps say there, in its numbers,
/// its maps and all that is predicted of them, whoever reads read noise, lines or dark offsets.
#[test]
fn steps_of_gain_are_at_each_gain_a_sensor_without_steps() {
    let step = |gain_db: f64, factor: f64| GainStepDescription {
        gain_db,
        read_noise_e: Some(3.0 * factor),
        row_noise_e: Some(1.0 * factor),
        column_noise_e: Some(0.8 * factor),
        dsnu_e: Some(2.0 * factor),
        dsnu_row_e: Some(0.5 * factor),
        dsnu_column_e: Some(0.7 * factor),
        // 65 + 30·K/K₀ at the gain of the factor, which falls by half over 24 dB.
        black_level_dn: Some(65 + (30.0 * 10f64.powf(-24.0 * factor.log2() / 20.0)).round() as u32),
    };
    for preset in ["sony-imx249-mono", "generic-cmos-color"] {
        let of = |noise: NoiseDescription, black_level_dn| {
            let mut description: SensorDescription = presets::table(preset).expect("listed").try_into().expect("keys");
            description.noise = noise;
            description.adc.black_level_dn = black_level_dn;
            description.adc.gain_db_range = [-6.0, 30.0];
            SensorModel::new(preset, &description, presets::library_spectrum).expect("a sensor")
        };
        let stepped = of(
            NoiseDescription { gain_steps: vec![step(0.0, 1.0), step(24.0, 0.5)], ..NoiseDescription::default() },
            64,
        );
        let key = NoiseKey { seed: 5, frame: 0 };
        let mut noises = Vec::new();
        for gain_db in [-6.0_f64, 0.0, 6.0, 12.0, 24.0, 30.0] {
            // log₂ falls by 1 over 24 dB, and ends hold.
            let factor = 0.5f64.powf((gain_db / 24.0).clamp(0.0, 1.0));
            let s = step(0.0, factor);
            let [read_noise_e, row_noise_e, column_noise_e, dsnu_e, dsnu_row_e, dsnu_column_e] =
                [s.read_noise_e, s.row_noise_e, s.column_noise_e, s.dsnu_e, s.dsnu_row_e, s.dsnu_column_e]
                    .map(Option::unwrap_or_default);
            let noise = NoiseDescription {
                read_noise_e,
                row_noise_e,
                column_noise_e,
                dsnu_e,
                dsnu_row_e,
                dsnu_column_e,
                ..NoiseDescription::default()
            };
            let plain = of(noise, s.black_level_dn.unwrap_or_default());
            let exposure = Exposure { gain: Decibels(gain_db), ..Exposure::of(Seconds(0.05)) };
            let facts = |sensor: &SensorModel| {
                let clipped = sensor.clipped_blacks(&exposure, Stages::ALL).is_some();
                let profile = sensor.noise_profile(&exposure).unwrap_or_default();
                let of_light = [0.0, 100.0].map(|e| sensor.noise_variance(Electrons(e), &exposure));
                let alone = sensor.signal_variance(Electrons(50.0), &exposure);
                let levels = [sensor.saturation_capacity(&exposure).0, sensor.number(Electrons(50.0), exposure.gain)];
                (clipped, [profile, of_light, [alone, sensor.read_noise(&exposure).0], levels].concat())
            };
            let (found, wanted) = (facts(&stepped), facts(&plain));
            assert_eq!(found.0, wanted.0);
            for (a, b) in found.1.iter().zip(&wanted.1) {
                // Logarithms, powers and sums of f64.
                assert!((a / b - 1.0).abs() < 1e-12, "{preset} {gain_db} dB: {a} {b}");
            }
            noises.push(found.1[5]);
            let expose = |sensor: &SensorModel| {
                expose_with_maps(&light(sensor), sensor, &exposure, Stages::ALL, key, &NoiseMap::ALL).expect("exposed")
            };
            let ((raw, maps), (wanted_raw, wanted_maps)) = (expose(&stepped), expose(&plain));
            let levels = |raw: &RawImage| (raw.black_level_dn.clone(), raw.white_level_dn);
            assert_eq!(levels(&raw), levels(&wanted_raw), "{preset} {gain_db} dB");
            // Numbers are multiplied and added above the black level of their gain.
            let binning = Binning { factor: [2, 2], method: BinningMethod::Mean };
            let processed = Exposure {
                digital_gain: Decibels(3.0),
                region: RegionOfInterest { binning, ..RegionOfInterest::WHOLE },
                ..exposure
            };
            let [a, b] = [&stepped, &plain].map(|sensor| {
                crate::expose(&light(sensor), sensor, &processed, Stages::ALL, key).expect("an image").data
            });
            assert!(a.iter().zip(&b).all(|(a, b)| a.abs_diff(*b) <= 2), "{preset} {gain_db} dB");
            // A last bit of σ moves a number that lies on the edge of rounding.
            let moved = raw.data.iter().zip(&wanted_raw.data).filter(|(a, b)| a != b).count();
            assert!(moved <= raw.data.len() / 1000, "{preset} {gain_db} dB: {moved}");
            for map in [NoiseMap::ReadNoiseE, NoiseMap::RowNoiseE, NoiseMap::ColumnNoiseE, NoiseMap::DsnuE] {
                assert_eq!(stepped.has_map(map), plain.has_map(map));
                let of = |maps: &crate::NoiseMaps| {
                    let is_map =
                        |plane: &&photosite_core::image::Channel| plane.name.split('.').next() == Some(map.name());
                    maps.planes.channels().iter().find(is_map).map(|plane| plane.data.clone())
                };
                let (found, wanted) = (of(&maps).expect("a map"), of(&wanted_maps).expect("a map"));
                assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() <= 1e-5 * (1.0 + b.abs())), "{map:?}");
                assert!(found.iter().any(|value| *value != 0.0), "{map:?}");
            }
        }
        assert_eq!((noises[0], noises[5]), (3.0, 1.5));
        assert!(stepped.gain_beyond_steps(&Exposure { gain: Decibels(30.0), ..Exposure::of(Seconds(1.0)) }).is_some());
        assert_eq!(stepped.gain_beyond_steps(&Exposure::of(Seconds(1.0))), None);
    }
}
