//! Sensors and light that the tests of the sensor share.

use photosite::image::Planes;
use photosite::sensor::{
    Architecture, Ccd, CcdArchitecture, Converter, Counting, DualGain, Exposure, FixedPattern, Noise, Overscan,
    SensorModel, Spad, Stage, presets,
};
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
        dual_gain: None,
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

/// An interline CCD without any losses.
pub(crate) fn ideal_ccd() -> Ccd {
    Ccd {
        architecture: CcdArchitecture::Interline,
        smear_row_time: Seconds(0.0),
        vertical_inefficiency: 0.0,
        horizontal_inefficiency: 0.0,
        anti_blooming_factor: 1.0,
        overscan: Overscan::default(),
    }
}

/// A sensor of the kind that has this stage, with every other effect of its kind, too.
pub(crate) fn noisy_sensor_with(stage: Stage) -> SensorModel {
    let mut sensor = noisy_sensor();
    sensor.brighter_fatter_per_e = [2e-5, 1e-5];
    match stage {
        Stage::Smear | Stage::Blooming | Stage::VerticalTransfer | Stage::HorizontalTransfer => {
            sensor.architecture = Architecture::Ccd(Ccd {
                smear_row_time: Seconds(1e-4),
                vertical_inefficiency: 1e-3,
                horizontal_inefficiency: 2e-3,
                overscan: Overscan { prescan_columns: 2, columns: 3, rows: 4 },
                ..ideal_ccd()
            });
        }
        Stage::PhotonCounting => {
            let counting = Counting::FreeRunning { dead_time: Seconds(1e-4) };
            sensor.architecture = Architecture::Spad(Spad { counting, afterpulsing: 0.02 });
        }
        Stage::LowGainReadNoise => {
            let branch = |conversion_gain_dn_per_e| Converter {
                bits: 12,
                conversion_gain_dn_per_e,
                black_level_dn: 200,
                ..sensor.converter.clone()
            };
            let dual_gain = DualGain { high: branch(8.0), low: branch(1.0), low_read_noise: Electrons(50.0) };
            sensor.converter.dual_gain = Some(Box::new(dual_gain));
        }
        Stage::PhotoResponse
        | Stage::ShotNoise
        | Stage::DarkCurrent
        | Stage::BrighterFatter
        | Stage::FullWell
        | Stage::DarkOffset
        | Stage::ReadNoise => {}
    }
    sensor
}

/// The figures of a CCD, to be changed.
fn ccd_of(sensor: &mut SensorModel) -> &mut Ccd {
    match &mut sensor.architecture {
        Architecture::Ccd(ccd) => ccd,
        Architecture::Cmos | Architecture::Spad(_) => panic!("no CCD"),
    }
}

/// The same sensor without the effect of one stage.
pub(crate) fn without(sensor: &SensorModel, stage: Stage) -> SensorModel {
    let mut ideal = sensor.clone();
    match stage {
        Stage::PhotoResponse => ideal.noise.prnu = FixedPattern::default(),
        // Light without shot noise is not a sensor's to have, nor is a counter that counts all.
        Stage::ShotNoise | Stage::PhotonCounting => {}
        Stage::Smear => ccd_of(&mut ideal).smear_row_time = Seconds(0.0),
        Stage::Blooming => ccd_of(&mut ideal).anti_blooming_factor = 1e9,
        Stage::VerticalTransfer => ccd_of(&mut ideal).vertical_inefficiency = 0.0,
        Stage::HorizontalTransfer => ccd_of(&mut ideal).horizontal_inefficiency = 0.0,
        Stage::BrighterFatter => ideal.brighter_fatter_per_e = [0.0; 2],
        Stage::LowGainReadNoise => {
            ideal.converter.dual_gain.as_mut().expect("has two gains").low_read_noise = Electrons(0.0);
        }
        Stage::DarkCurrent => ideal.noise.dark_current_e_per_s = 0.0,
        Stage::FullWell => ideal.full_well = Electrons(1e9),
        Stage::DarkOffset => ideal.noise.dsnu = FixedPattern::default(),
        Stage::ReadNoise => ideal.noise.read = Electrons(0.0),
    }
    ideal
}
