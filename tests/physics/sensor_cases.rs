//! Sensors and light that the tests of the sensor share.

use photosite::image::Planes;
use photosite::sensor::{Converter, Exposure, FixedPattern, Noise, SensorModel, Stage, presets};
use photosite::units::{Celsius, Decibels, Electrons, Seconds};

/// One second at 25 °C and 0 dB.
pub(crate) const EXPOSURE: Exposure =
    Exposure { time: Seconds(1.0), gain: Decibels(0.0), temperature: Celsius(25.0), frame_interval: None };

/// A monochrome sensor of 16 bits with a system gain of 1 DN/e⁻, a black level of 1000 DN and no noise.
pub(crate) fn quiet_sensor() -> SensorModel {
    let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
    sensor.noise = Noise::NONE;
    sensor.full_well = Electrons(60_000.0);
    sensor.converter = Converter {
        bits: 16,
        conversion_gain_dn_per_e: 1.0,
        black_level_dn: 1000,
        gain_range: [Decibels(0.0), Decibels(24.0)],
    };
    sensor
}

/// The same mean electrons in every pixel of every channel.
pub(crate) fn flat(sensor: &SensorModel, width: usize, height: usize, mean_e: f32) -> Planes {
    let mut planes = Planes::zeros(width, height, sensor.cfa.channels());
    for channel in planes.channels_mut() {
        channel.data.fill(mean_e);
    }
    planes
}

/// A sensor with every effect that there is, strong enough to show at 2000 e⁻.
pub(crate) fn noisy_sensor() -> SensorModel {
    let mut sensor = quiet_sensor();
    sensor.noise.prnu = FixedPattern { pixel: 0.02, row: 0.01, column: 0.01 };
    sensor.noise.dark_current_e_per_s = 400.0;
    sensor.noise.dsnu = FixedPattern { pixel: 60.0, row: 30.0, column: 30.0 };
    sensor.noise.read = Electrons(40.0);
    sensor.full_well = Electrons(2450.0);
    sensor
}

/// The same sensor without the effect of one stage.
pub(crate) fn without(sensor: &SensorModel, stage: Stage) -> SensorModel {
    let mut ideal = sensor.clone();
    match stage {
        Stage::PhotoResponse => ideal.noise.prnu = FixedPattern::default(),
        // Light without shot noise is not a sensor's to have.
        Stage::ShotNoise => {}
        Stage::DarkCurrent => ideal.noise.dark_current_e_per_s = 0.0,
        Stage::FullWell => ideal.full_well = Electrons(1e9),
        Stage::DarkOffset => ideal.noise.dsnu = FixedPattern::default(),
        Stage::ReadNoise => ideal.noise.read = Electrons(0.0),
    }
    ideal
}
