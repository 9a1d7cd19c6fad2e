//! One exposure, from mean photo-electrons to digital numbers, as the list of its physical stages.

use crate::Invalid;
use crate::image::Planes;
use crate::raw::{RawImage, RawMetadata};

use super::amplifiers::{AmplifierNonlinearity, ColumnAmplifiers, Gain};
use super::charge_plane::RowStage;
use super::converter::Digitiser;
use super::crosstalk::spread;
use super::dark_current::{DarkCurrent, HotPixels};
use super::dark_offset::DarkOffset;
use super::dead_pixels::DeadPixels;
use super::defective_numbers::{StuckPixels, TransmissionErrors};
use super::flicker::add_flicker;
use super::full_well::FullWell;
use super::line_noise::{ColumnNoise, RowNoise};
use super::noise_key::Streams;
use super::photo_response::PhotoResponse;
use super::read_noise::ReadNoise;
use super::reset_noise::ResetNoise;
use super::shot_noise::ShotNoise;
use super::stage::{Stage, Stages};
use super::telegraph::Telegraph;
use super::{Exposure, NoiseKey, SensorModel, charge_generation};

/// What every stage of one picture may know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<'a> {
    pub(super) sensor: &'a SensorModel,
    pub(super) exposure: &'a Exposure,
    pub(super) stages: Stages,
    pub(super) key: NoiseKey,
    /// Columns and rows of the picture.
    pub(super) size: [usize; 2],
}

impl Frame<'_> {
    /// Random numbers that are new in each frame, unless the stage is switched off.
    pub(super) fn temporal(&self, stage: Stage) -> Option<Streams> {
        self.stages.has(stage).then(|| self.key.temporal(stage))
    }

    /// Random numbers that stay from frame to frame, unless the stage is switched off.
    pub(super) fn fixed(&self, stage: Stage) -> Option<Streams> {
        self.stages.has(stage).then(|| self.key.fixed(stage))
    }
}

/// Exposes the sensor to light that frees `mean_electrons` on average during the exposure: e⁻, noise-free, finite and
/// not negative, a plane for each of the sensor's channels, of which every pixel uses its own. The picture may be
/// smaller than the sensor; the colour filter array starts at its top-left pixel.
pub fn expose(
    mean_electrons: &Planes,
    sensor: &SensorModel,
    exposure: &Exposure,
    stages: Stages,
    key: NoiseKey,
) -> Result<RawImage, Invalid> {
    exposure.validate(sensor)?;
    let [width, height] = [mean_electrons.width(), mean_electrons.height()];
    let size = [width * sensor.cfa.samples_per_pixel(), height];
    let frame = Frame { sensor, exposure, stages, key, size };

    // Light and heat free electrons in each pixel.
    let mut charge = charge_generation::collect(mean_electrons, &sensor.cfa)?;
    spread(&mut charge, &frame);
    let photo_response = PhotoResponse::new(&frame);
    let dead_pixels = DeadPixels::new(&frame);
    let shot_noise = ShotNoise::new(&frame);
    let dark_current = DarkCurrent::new(&frame);
    let hot_pixels = HotPixels::new(&frame);
    charge.for_each_row(|row| {
        photo_response.apply(row);
        dead_pixels.apply(row);
        shot_noise.apply(row);
        dark_current.apply(row);
        hot_pixels.apply(row);
    });

    // The pixels hold them. Here belong effects of whole planes of collected charge: a brighter-fatter effect, blooming.
    let full_well = FullWell::new(&frame);
    charge.for_each_row(|row| full_well.apply(row));

    // CCDs move the charge to their output. Here belong smear and charge transfer.

    // Amplifiers turn charge into voltages, converters those into digital numbers.
    add_flicker(&mut charge, &frame);
    let reset_noise = ResetNoise::new(&frame);
    let telegraph = Telegraph::new(&frame);
    let dark_offset = DarkOffset::new(&frame);
    let read_noise = ReadNoise::new(&frame);
    let row_noise = RowNoise::new(&frame);
    let column_noise = ColumnNoise::new(&frame);
    let amplifier_nonlinearity = AmplifierNonlinearity::new(&frame);
    let gain = Gain::new(&frame);
    let column_amplifiers = ColumnAmplifiers::new(&frame);
    let digitiser = Digitiser::new(&frame);
    let stuck_pixels = StuckPixels::new(&frame);
    let transmission_errors = TransmissionErrors::new(&frame);
    let data = charge.read_out(|row, numbers| {
        reset_noise.apply(row);
        telegraph.apply(row);
        dark_offset.apply(row);
        read_noise.apply(row);
        row_noise.apply(row);
        column_noise.apply(row);
        amplifier_nonlinearity.apply(row);
        gain.apply(row);
        column_amplifiers.apply(row);
        digitiser.convert(row, numbers);
        stuck_pixels.apply(numbers);
        transmission_errors.apply(numbers);
    });

    Ok(RawImage {
        width,
        height,
        data,
        cfa: sensor.cfa.clone(),
        bits: sensor.converter.bits,
        black_level_dn: sensor.converter.black_level_dn.into(),
        white_level_dn: sensor.white_level_dn(exposure),
        metadata: RawMetadata {
            camera_model: sensor.name.clone(),
            exposure_time_s: exposure.time.0,
            pixel_pitch_m: Some(sensor.pixel_pitch_m),
            noise_profile: vec![sensor.noise_profile(exposure); sensor.cfa.channels().len()],
            ..RawMetadata::default()
        },
        ..RawImage::default()
    })
}
