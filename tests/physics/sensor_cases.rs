//! Sensors and light that the tests of the sensor share.

use photosite::image::Planes;
use photosite::sensor::{
    Architecture, Ccd, CcdArchitecture, Converter, Counting, Defects, DualGain, Exposure, FixedPattern, Flicker,
    FlickerOrder, ImageLag, Kernel, LowPass, Noise, Overscan, ReadOutNoise, Reset, SensorModel, Spad, Stage,
    TelegraphSignal, presets,
};
use photosite::units::{Decibels, Electrons, Seconds};

/// One second at 25 °C and 0 dB.
pub(crate) const EXPOSURE: Exposure = Exposure::of(Seconds(1.0));

/// A monochrome sensor of 16 bits with a system gain of 1 DN/e⁻, a black level of 1000 DN and no noise.
pub(crate) fn quiet_sensor() -> SensorModel {
    let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
    sensor.noise = Noise::NONE;
    sensor.full_well = Electrons(60_000.0);
    sensor.converter = Converter {
        bits: 16,
        conversion_gain_dn_per_e: 1.0,
        black_level: 1000.into(),
        gain_range: [Decibels(0.0), Decibels(24.0)],
        ..Converter::ideal()
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
    sensor.crosstalk = Kernel::new(&[vec![0.1, 0.8, 0.1]]).map(|kernel| vec![kernel]);
    sensor.full_well = Electrons(2450.0);
    sensor.noise = Noise {
        read_out: ReadOutNoise {
            read: Electrons(40.0),
            row: Electrons(20.0),
            column: Electrons(30.0),
            dsnu: FixedPattern { pixel: 60.0, row: 30.0, column: 30.0 },
        }
        .into(),
        read_degrees_of_freedom: Some(4.0),
        read_spread: 0.3,
        dark_current_e_per_s: 400.0,
        dark_current_nonuniformity: 0.3,
        prnu: FixedPattern { pixel: 0.02, row: 0.01, column: 0.01 },
        reset: Reset::Capacitance(5e-15),
        flicker: Flicker { noise: Electrons(25.0), exponent: 1.0, order: FlickerOrder::ColumnParallel },
        telegraph: TelegraphSignal { pixels: 0.1, amplitude: Electrons(50.0), high: Seconds(2.0), low: Seconds(1.0) },
        transmission_errors: 0.01,
        defects: Defects { hot: 0.02, hot_dark_current_e_per_s: 300.0, dead: 0.01, stuck: 0.01 },
        ..sensor.noise
    };
    sensor.converter = Converter {
        amplifier_nonlinearity: vec![-0.02, 0.01],
        inl_dn: 5.0,
        dnl_dn: 0.3,
        column_gain: 0.01,
        column_offset_dn: 8.0,
        ..sensor.converter
    };
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
        Stage::ImageLag => {
            sensor.image_lag = Some(ImageLag { fraction: 0.02, electrons: Electrons(30.0), decay: 0.3 });
        }
        Stage::VideoBandwidth => sensor.video.low_pass = Some(LowPass { missing: 0.3 }),
        Stage::PhotonCounting => {
            let counting = Counting::FreeRunning { dead_time: Seconds(1e-4) };
            sensor.architecture = Architecture::Spad(Spad { counting, afterpulsing: 0.02 });
        }
        Stage::LowGainReadNoise => {
            sensor.converter = quiet_sensor().converter;
            let branch = |conversion_gain_dn_per_e| Converter {
                bits: 12,
                conversion_gain_dn_per_e,
                black_level: 200.into(),
                ..sensor.converter.clone()
            };
            let dual_gain = DualGain { high: branch(8.0), low: branch(1.0), low_read_noise: Electrons(50.0) };
            sensor.converter.dual_gain = Some(Box::new(dual_gain));
        }
        Stage::Crosstalk
        | Stage::PhotoResponse
        | Stage::DeadPixels
        | Stage::ShotNoise
        | Stage::DarkCurrent
        | Stage::DarkCurrentNonuniformity
        | Stage::HotPixels
        | Stage::BrighterFatter
        | Stage::FullWell
        | Stage::Flicker
        | Stage::ResetNoise
        | Stage::Telegraph
        | Stage::DarkOffset
        | Stage::ReadNoise
        | Stage::RowNoise
        | Stage::ColumnNoise
        | Stage::AmplifierNonlinearity
        | Stage::ColumnAmplifiers
        | Stage::ConverterNonlinearity
        | Stage::StuckPixels
        | Stage::TransmissionErrors => {}
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

/// The same sensor without the effect of one stage, where there can be such a sensor.
pub(crate) fn without(sensor: &SensorModel, stage: Stage) -> Option<SensorModel> {
    let mut ideal = sensor.clone();
    let (noise, converter) = (&mut ideal.noise, &mut ideal.converter);
    let none = Electrons(0.0);
    match stage {
        Stage::Crosstalk => ideal.crosstalk = None,
        Stage::PhotoResponse => noise.prnu = FixedPattern::default(),
        Stage::DeadPixels => noise.defects.dead = 0.0,
        // Light without shot noise is not a sensor's to have.
        // Nor is a counter that counts all.
        Stage::ShotNoise | Stage::PhotonCounting => return None,
        Stage::Smear => ccd_of(&mut ideal).smear_row_time = Seconds(0.0),
        Stage::Blooming => ccd_of(&mut ideal).anti_blooming_factor = 1e9,
        Stage::VerticalTransfer => ccd_of(&mut ideal).vertical_inefficiency = 0.0,
        Stage::HorizontalTransfer => ccd_of(&mut ideal).horizontal_inefficiency = 0.0,
        Stage::BrighterFatter => ideal.brighter_fatter_per_e = [0.0; 2],
        Stage::LowGainReadNoise => {
            converter.dual_gain.as_mut().expect("has two gains").low_read_noise = none;
        }
        Stage::DarkCurrent => noise.dark_current_e_per_s = 0.0,
        Stage::DarkCurrentNonuniformity => noise.dark_current_nonuniformity = 0.0,
        Stage::HotPixels => noise.defects.hot = 0.0,
        // The amplifiers bend with the charge over the full well, so that it cannot be changed alone.
        Stage::FullWell => return None,
        Stage::ImageLag => ideal.image_lag = None,
        Stage::ResetNoise => noise.reset = Reset::Cancelled,
        Stage::Telegraph => noise.telegraph.pixels = 0.0,
        Stage::Flicker => noise.flicker.noise = none,
        Stage::DarkOffset => noise.read_out.change(|noise| noise.dsnu = FixedPattern::default()),
        Stage::ReadNoise => noise.read_out.change(|noise| noise.read = none),
        Stage::RowNoise => noise.read_out.change(|noise| noise.row = none),
        Stage::ColumnNoise => noise.read_out.change(|noise| noise.column = none),
        Stage::AmplifierNonlinearity => converter.amplifier_nonlinearity.clear(),
        Stage::ColumnAmplifiers => (converter.column_gain, converter.column_offset_dn) = (0.0, 0.0),
        Stage::ConverterNonlinearity => (converter.inl_dn, converter.dnl_dn) = (0.0, 0.0),
        Stage::VideoBandwidth => ideal.video.low_pass = None,
        Stage::StuckPixels => noise.defects.stuck = 0.0,
        Stage::TransmissionErrors => noise.transmission_errors = 0.0,
    }
    Some(ideal)
}
