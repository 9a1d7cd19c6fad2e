//! One exposure, from mean photo-electrons to digital numbers, as the list of its physical stages.

use crate::Invalid;
use crate::image::Planes;
use crate::raw::{RawImage, RawMetadata};

use super::charge_plane::RowStage;
use super::converter::Digitiser;
use super::dark_current::DarkCurrent;
use super::dark_offset::DarkOffset;
use super::full_well::FullWell;
use super::noise_key::Streams;
use super::photo_response::PhotoResponse;
use super::read_noise::ReadNoise;
use super::shot_noise::ShotNoise;
use super::stage::{Stage, Stages};
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
    let photo_response = PhotoResponse::new(&frame);
    let shot_noise = ShotNoise::new(&frame);
    let dark_current = DarkCurrent::new(&frame);
    charge.for_each_row(|row| {
        photo_response.apply(row);
        shot_noise.apply(row);
        dark_current.apply(row);
    });

    // The pixels hold them. Here belong effects of whole planes of collected charge: a brighter-fatter effect, blooming.
    let full_well = FullWell::new(&frame);
    charge.for_each_row(|row| full_well.apply(row));

    // CCDs move the charge to their output. Here belong smear and charge transfer.

    // Amplifiers turn charge into voltages, converters those into digital numbers.
    let dark_offset = DarkOffset::new(&frame);
    let read_noise = ReadNoise::new(&frame);
    let digitiser = Digitiser::new(&sensor.converter, exposure.gain);
    let data = charge.read_out(|row, numbers| {
        dark_offset.apply(row);
        read_noise.apply(row);
        digitiser.convert(row, numbers);
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
