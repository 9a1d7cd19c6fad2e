//! Facts that keep an exposure from a card, by key.

use photosite_core::Invalid;

use crate::{Architecture, Converter, Exposure, Noise, RegionOfInterest, SensorModel, Stage, Stages, Video};

/// First fact of sensor or exposure that a card does not have; `None` where it has all. A fact that is new to sensors
/// does not compile until it has its line here.
pub(super) fn refusal(sensor: &SensorModel, exposure: &Exposure, stages: Stages) -> Option<Invalid> {
    let SensorModel {
        // What says nothing about digital numbers, or is in the light
        name: _,
        description: _,
        source: _,
        resolution: _,
        pixel_pitch_m: _,
        cells: _,
        fill_factor: _,
        cfa: _,
        filter: _,
        quantum_efficiency: _,
        // What the stages have in their words
        serial: _,
        shutter: _,
        masked: _,
        crosstalk: _,
        full_well: _,
        // Facts of stages
        brighter_fatter_per_e: _,
        image_lag: _,
        architecture,
        noise,
        logarithmic,
        converter,
        video,
        frame_grabber,
    } = sensor;
    let architecture = match architecture {
        Architecture::Cmos => None,
        Architecture::Ccd(_) => Some(("sensor.ccd", "the charge transfer of a CCD")),
        Architecture::Spad(_) => Some(("sensor.spad", "the counting of single photons")),
    };
    let Video { curve, low_pass: _ } = video;
    let Exposure { time: _, gain: _, digital_gain: _, temperature: _, frame_interval: _, region } = exposure;
    let RegionOfInterest { binning, pixels: _ } = region;
    let others = [
        (logarithmic.is_some(), "sensor.charge.logarithmic_reference_e_per_s", "a logarithmic response"),
        (
            has_tails(noise, converter, stages),
            "sensor.noise.read_noise_degrees_of_freedom",
            "read noise with heavy tails",
        ),
        (curve.is_some(), "sensor.video.gamma", "the curve of a video amplifier"),
        (frame_grabber.is_some(), "sensor.frame_grabber", "a frame grabber"),
        (!binning.is_none(), "exposure.binning", "binning"),
    ];
    let others = others.into_iter().find_map(|(is_there, key, what)| is_there.then_some((key, what)));
    let stage =
        || Stage::ALL.into_iter().filter(|&stage| stages.has(stage) && sensor.has_stage(stage)).find_map(of_stage);
    let (key, what) = architecture.or_else(stage).or(others)?;
    let message = format!("{what} cannot be exposed on a graphics card yet");
    Some(Invalid::new(key, message).help("expose with --device cpu"))
}

/// Key and words of a stage that cards do not have.
fn of_stage(stage: Stage) -> Option<(&'static str, &'static str)> {
    match stage {
        Stage::Crosstalk
        | Stage::PhotoResponse
        | Stage::DeadPixels
        | Stage::ShotNoise
        | Stage::DarkCurrent
        | Stage::DarkCurrentNonuniformity
        | Stage::HotPixels
        | Stage::FullWell
        | Stage::ResetNoise
        | Stage::DarkOffset
        | Stage::ReadNoise
        | Stage::LowGainReadNoise
        | Stage::RowNoise
        | Stage::ColumnNoise
        | Stage::AmplifierNonlinearity
        | Stage::ColumnAmplifiers
        | Stage::ConverterNonlinearity
        | Stage::StuckPixels
        | Stage::TransmissionErrors => None,
        Stage::Smear | Stage::Blooming | Stage::VerticalTransfer | Stage::HorizontalTransfer => {
            Some(("sensor.ccd", "the charge transfer of a CCD"))
        }
        Stage::PhotonCounting => Some(("sensor.spad", "the counting of single photons")),
        Stage::BrighterFatter => Some(("sensor.charge.brighter_fatter_per_e", "the brighter-fatter effect")),
        Stage::ImageLag => Some(("sensor.charge.image_lag", "image lag")),
        Stage::Flicker => Some(("sensor.noise.flicker.noise_e", "1/f noise")),
        Stage::Telegraph => Some(("sensor.noise.telegraph.pixels_per_million", "random telegraph noise")),
        Stage::VideoBandwidth => Some(("sensor.video.bandwidth_mhz", "the bandwidth of a video line")),
    }
}

/// Whether read noise takes part that follows Student's t distribution. A new fact of noise or converters does not
/// compile until it is named here.
fn has_tails(noise: &Noise, converter: &Converter, stages: Stages) -> bool {
    let Noise {
        read_degrees_of_freedom,
        // What the stages have in their words
        read_out: _,
        read_spread: _,
        dark_current_e_per_s: _,
        dark_current_reference: _,
        dark_current_law: _,
        dark_current_nonuniformity: _,
        prnu: _,
        prnu_map: _,
        dsnu_map: _,
        reset: _,
        transmission_errors: _,
        defects: _,
        defective_pixels: _,
        // Facts of stages
        flicker: _,
        telegraph: _,
    } = noise;
    let Converter {
        dual_gain,
        // What the stages have in their words
        bits: _,
        conversion_gain_dn_per_e: _,
        black_level: _,
        gain_range: _,
        amplifier_nonlinearity: _,
        inl_dn: _,
        dnl_dn: _,
        converters: _,
        column_gain: _,
        column_offset_dn: _,
        companding: _,
    } = converter;
    // The branches of two gains are without tails.
    read_degrees_of_freedom.is_some() && dual_gain.is_none() && stages.has(Stage::ReadNoise)
}
