//! Sensors and light that the tests of the sensor share.

use photosite::image::Planes;
use photosite::sensor::{Converter, Exposure, Noise, SensorModel, presets};
use photosite::units::{Celsius, Decibels, Electrons, Seconds};

/// One second at 25 °C and 0 dB.
pub(crate) const EXPOSURE: Exposure = Exposure { time: Seconds(1.0), gain: Decibels(0.0), temperature: Celsius(25.0) };

/// A monochrome sensor of 16 bits with a system gain of 1 DN/e⁻, a black level of 1000 DN and no noise.
pub(crate) fn quiet_sensor() -> SensorModel {
    let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
    sensor.noise = Noise {
        read: Electrons(0.0),
        dark_current_e_per_s: 0.0,
        dark_current_reference: Celsius(25.0),
        dark_current_doubling_k: 8.0,
        prnu: 0.0,
        dsnu: Electrons(0.0),
    };
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
