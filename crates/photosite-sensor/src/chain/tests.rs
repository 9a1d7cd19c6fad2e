//! Effects that a sensor has, and those that it has not, judged by its digital numbers.

use photosite_core::image::Planes;
use photosite_core::units::Seconds;

use super::expose_with_maps;
use crate::{Exposure, Noise, NoiseKey, NoiseMap, SensorDescription, SensorModel, Stage, Stages, presets};

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
