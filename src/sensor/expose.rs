//! One exposure, from mean photo-electrons to digital numbers, as the list of its physical stages.

use rayon::prelude::*;

use crate::Invalid;
use crate::image::Planes;
use crate::raw::{Cfa, RawImage, RawMetadata};
use crate::units::{Celsius, Decibels, Seconds};

use super::converter::Digitiser;
use super::dark_current::DarkCurrent;
use super::dark_offset::DarkOffset;
use super::full_well;
use super::photo_response::PhotoResponse;
use super::read_noise::ReadNoise;
use super::shot_noise::ShotNoise;
use super::{NoiseKey, SensorModel};

/// Settings of one exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// How long light and dark current are collected.
    pub time: Seconds,
    /// Analogue gain on top of the sensor's conversion gain.
    pub gain: Decibels,
    /// Temperature of the sensor.
    pub temperature: Celsius,
}

impl Exposure {
    /// Refuses what this sensor cannot do. Keys are those of the capture file's `[exposure]` table.
    pub fn validate(&self, sensor: &SensorModel) -> Result<(), Invalid> {
        if !(self.time.0.is_finite() && self.time.0 > 0.0) {
            return Err(Invalid::new("time_s", format!("must be above 0, got {}", self.time.0))
                .help("for example time_s = 0.01"));
        }
        let [low, high] = sensor.converter.gain_range;
        if !(low.0..=high.0).contains(&self.gain.0) {
            let message = format!("{} dB is not among the gains of sensor {}", self.gain.0, sensor.name);
            return Err(Invalid::new("gain_db", message).help(format!("write {} to {} dB", low.0, high.0)));
        }
        let dark = sensor.noise.dark_electrons(self.temperature, self.time);
        if !(self.temperature.0 > -crate::units::ZERO_CELSIUS && dark.0.is_finite()) {
            let message = format!("no sensor works at {} °C", self.temperature.0);
            return Err(Invalid::new("temperature_c", message).help("for example temperature_c = 25.0"));
        }
        Ok(())
    }
}

/// Which stages take part. Switching one off leaves the random numbers of all others as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "each is the stage of that name in `expose`")]
pub struct Stages {
    pub photo_response: bool,
    pub shot_noise: bool,
    pub dark_current: bool,
    pub dark_offset: bool,
    pub full_well: bool,
    pub read_noise: bool,
}

impl Stages {
    /// The real sensor.
    pub const ALL: Self = Self {
        photo_response: true,
        shot_noise: true,
        dark_current: true,
        dark_offset: true,
        full_well: true,
        read_noise: true,
    };
    /// Nothing but gain and converter.
    pub const NONE: Self = Self {
        photo_response: false,
        shot_noise: false,
        dark_current: false,
        dark_offset: false,
        full_well: false,
        read_noise: false,
    };
}

impl Default for Stages {
    fn default() -> Self {
        Self::ALL
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
    let channels = channel_planes(mean_electrons, &sensor.cfa)?;
    let dark_electrons = sensor.noise.dark_electrons(exposure.temperature, exposure.time);

    let photo_response = PhotoResponse::new(sensor.noise.prnu, key);
    let shot_noise = ShotNoise::new(key);
    let dark_current = DarkCurrent::new(dark_electrons, key);
    let dark_offset = DarkOffset::new(sensor.noise.dsnu, key);
    let read_noise = ReadNoise::new(sensor.noise.read, key);
    let digitiser = Digitiser::new(&sensor.converter, exposure.gain);

    // The numbers of a pixel with several come from detectors of their own, each with its own noise.
    let digital_number = |mean_e: f32, pixel: usize| -> u16 {
        let mut charge = f64::from(mean_e);
        if stages.photo_response {
            charge = photo_response.apply(charge, pixel);
        }
        if stages.shot_noise {
            charge = shot_noise.apply(charge, pixel);
        }
        if stages.dark_current {
            charge = dark_current.apply(charge, pixel);
        }
        if stages.dark_offset {
            charge = dark_offset.apply(charge, pixel);
        }
        if stages.full_well {
            charge = full_well::clip(charge, sensor.full_well);
        }
        if stages.read_noise {
            charge = read_noise.apply(charge, pixel);
        }
        digitiser.convert(charge)
    };

    let (width, height) = (mean_electrons.width(), mean_electrons.height());
    let samples = sensor.cfa.samples_per_pixel();
    let row_length = width * samples;
    let mut data = vec![0u16; row_length * height];
    data.par_chunks_mut(row_length.max(1)).enumerate().for_each(|(y, row)| {
        let tile_width = sensor.cfa.tile_size().0;
        // Numbers of one column of the tile share a channel, so the inner loop needs no look-up.
        for column in 0..tile_width {
            let plane = &channels[sensor.cfa.channel_at(column, y)][y * width..(y + 1) * width];
            for x in (column..row_length).step_by(tile_width) {
                row[x] = digital_number(plane[x / samples], y * row_length + x);
            }
        }
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

/// The planes of the CFA's channels, in its order, checked to hold electrons.
pub(super) fn channel_planes<'a>(planes: &'a Planes, cfa: &Cfa) -> Result<Vec<&'a [f32]>, Invalid> {
    let find = |name: &String| {
        let Some(plane) = planes.plane(name) else {
            let held: Vec<&str> = planes.channels().iter().map(|c| c.name.as_str()).collect();
            let message = format!("the sensor needs a channel {name}, but the picture has {}", held.join(", "));
            return Err(Invalid::new("", message));
        };
        match first_impossible(plane) {
            Some(pixel) => {
                let (x, y) = (pixel % planes.width(), pixel / planes.width());
                let message = format!("channel {name} holds {} electrons at column {x}, row {y}", plane[pixel]);
                Err(Invalid::new("", message).help("mean electrons are finite numbers of 0 and more"))
            }
            None => Ok(plane),
        }
    };
    cfa.channels().iter().map(find).collect()
}

/// The first pixel that holds no number of electrons.
fn first_impossible(plane: &[f32]) -> Option<usize> {
    const BLOCK: usize = 1 << 14;
    let possible = |e: f32| (0.0..f32::INFINITY).contains(&e);
    // Whole blocks without an early end, which the compiler turns into vector instructions.
    let block =
        plane.par_chunks(BLOCK).position_first(|block| !block.iter().fold(true, |all, &e| all & possible(e)))?;
    plane[block * BLOCK..].iter().position(|&e| !possible(e)).map(|i| block * BLOCK + i)
}
