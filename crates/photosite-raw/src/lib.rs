//! Raw images: the mosaic of digital numbers that leaves the sensor, with what a developer needs to know about it.
//!
//! In: digital numbers from `photosite-sensor`. Out: files (DNG, TIFF, PGM, NPY). Development to RGB is left to
//! `photosite-develop`.

#![forbid(unsafe_code)]

mod area;
mod black_level;
mod calibration;
mod cfa;
mod distortion;
mod dng;
mod exif;
mod gain_map;
mod lens_model;
mod lossless_jpeg;
mod npy;
mod opcode;
mod openable;
mod orientation;
mod pnm;
mod rational;
pub mod rules;
mod tag;
mod tags;
mod thumbnail;
mod tiff;
mod warp;

pub use area::{AreaSpec, PixelArea, Pixels};
pub use black_level::BlackLevel;
pub use calibration::{ColourCalibration, LightSource};
pub use cfa::{Cfa, NAMED as NAMED_FILTER_ARRAYS};
pub use distortion::Distortion;
pub use dng::{
    DngCompression, dng_can_hold, read_dng, read_dng_or_tiff, read_profile, write_compressed_dng, write_dng,
};
pub use exif::Exif;
pub use gain_map::{Between, GainMap, Reach};
pub use lens_model::{LensModel, Undistortion};
pub use npy::with_short_header;
pub use npy::{NpyImage, NpyValues, read_npy, read_npy_image, write_npy};
pub use opcode::{Frame, Opcode, PerLine};
pub use orientation::Orientation;
pub use pnm::{read_pnm, write_pgm};
pub use tiff::{TiffNotes, read_tiff, tiff_notes, write_tiff};
pub use tiff::{read_pixels, refuse_planar_tiles};
pub use warp::{Warp, WarpKind};

use std::borrow::Cow;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use photosite_core::{Invalid, memory};

/// Most pixels along a side of an image.
const MAX_SIDE: usize = 65_535;

/// Refuses images whose values of 16 bits there is no memory for, and as much again while they are read.
fn check_memory([width, height]: [usize; 2], samples: usize) -> Result<(), Invalid> {
    let bytes = (width as u64).saturating_mul(height as u64).saturating_mul(4 * samples as u64);
    memory::check(bytes, &format!("reading its {width} × {height} pixels"), "")
}

/// An image of digital numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RawImage {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Digital numbers, row by row from the top-left pixel: one a pixel in a mosaic, or those of all channels, one
    /// beside the other ([`Cfa::samples_per_pixel`]). Serialised forms are without them.
    #[serde(skip)]
    pub data: Vec<u16>,
    /// Colour filter array: the channel that each value belongs to.
    pub cfa: Cfa,
    /// The pixels that see light; `None` where all do. The others are masked and show the black level.
    pub active_area: Option<PixelArea>,
    /// Bits of the digital numbers, 1–16.
    pub bits: u32,
    /// Linearisation table: for each stored value one in proportion to light, the last for all beyond. `None` where
    /// stored values are linear.
    pub linearisation: Option<Vec<u16>>,
    /// Linear number of no light, DN.
    pub black_level_dn: BlackLevel,
    /// Smallest linear number at which a pixel counts as saturated, DN: that of all channels, or the smallest of theirs.
    pub white_level_dn: u16,
    /// Saturation of each channel, DN of linear values, where channels differ.
    pub channel_whites_dn: Option<Vec<u16>>,
    /// Facts about how the image was taken.
    pub metadata: RawMetadata,
}

impl Default for RawImage {
    /// A monochrome image of 16 bits that has no pixels yet.
    fn default() -> Self {
        Self {
            width: 0,
            height: 0,
            data: Vec::new(),
            cfa: Cfa::mono(),
            active_area: None,
            bits: 16,
            linearisation: None,
            black_level_dn: BlackLevel::default(),
            white_level_dn: u16::MAX,
            channel_whites_dn: None,
            metadata: RawMetadata::default(),
        }
    }
}

impl RawImage {
    /// Digital numbers of which a file says nothing but that they go up to `maximum`.
    pub fn bare(width: usize, height: usize, data: Vec<u16>, cfa: Cfa, maximum: u16) -> Self {
        Self { width, height, data, cfa, bits: bits_for(maximum), white_level_dn: maximum, ..Self::default() }
    }

    /// Image with linear values, by its linearisation table.
    pub fn linear(&self) -> Cow<'_, Self> {
        let Some(table) = &self.linearisation else { return Cow::Borrowed(self) };
        let mut data = self.data.clone();
        linearise(&mut data, table);
        Cow::Owned(Self { bits: bits_for(self.white_level_dn), linearisation: None, ..self.with_data(data) })
    }

    /// Other digital numbers of which all holds that holds of these.
    pub fn with_data(&self, data: Vec<u16>) -> Self {
        Self {
            data,
            cfa: self.cfa.clone(),
            linearisation: self.linearisation.clone(),
            black_level_dn: self.black_level_dn.clone(),
            channel_whites_dn: self.channel_whites_dn.clone(),
            metadata: self.metadata.clone(),
            ..*self
        }
    }

    /// Smallest linear number at which a pixel counts as saturated in a channel, DN.
    pub fn white_of(&self, channel: usize) -> u16 {
        self.channel_whites_dn.as_ref().and_then(|whites| whites.get(channel)).copied().unwrap_or(self.white_level_dn)
    }

    /// Number of saturated values.
    pub fn saturated(&self) -> usize {
        let row_length = self.row_length().max(1);
        let is_saturated =
            |&(i, &dn): &(usize, &u16)| dn >= self.white_of(self.cfa.channel_at(i % row_length, i / row_length));
        self.data.iter().enumerate().filter(is_saturated).count()
    }

    /// Values in a row of `data`.
    pub fn row_length(&self) -> usize {
        self.width * self.cfa.samples_per_pixel()
    }

    /// The pixels that see light.
    pub fn active(&self) -> PixelArea {
        self.active_area.unwrap_or(PixelArea { x: 0, y: 0, width: self.width, height: self.height })
    }

    /// Layout from the corner of the active area on.
    pub fn active_cfa(&self) -> Cfa {
        let PixelArea { x, y, .. } = self.active();
        self.cfa.from(x, y)
    }

    /// Refuses an image whose parts do not belong together.
    pub fn validate(&self) -> Result<(), Invalid> {
        if self.data.len() != self.row_length() * self.height {
            let message = format!("{} numbers for {} × {} pixels", self.data.len(), self.width, self.height);
            let help = format!("each pixel has {}", self.cfa.samples_per_pixel());
            return Err(Invalid::new("", message).help(help));
        }
        self.validate_area()
    }

    /// Refuses an active area that goes beyond the image, whatever numbers the image has.
    pub fn validate_area(&self) -> Result<(), Invalid> {
        let area = self.active();
        let fits = |first: usize, length: usize, side: usize| first.checked_add(length).is_some_and(|end| end <= side);
        if !(fits(area.x, area.width, self.width) && fits(area.y, area.height, self.height)) {
            let message = format!("the active area {area} goes beyond {} × {} pixels", self.width, self.height);
            return Err(Invalid::new("active_area", message));
        }
        Ok(())
    }

    /// The active area alone, as an image of its own.
    pub fn cropped(&self) -> Self {
        let Some(area) = self.active_area else { return self.clone() };
        let mut cropped = self.part(area);
        cropped.metadata.default_crop = self.metadata.default_crop;
        cropped
    }

    /// A part that lies within the image, as an image of its own, all of which is developed. What is known of the lens
    /// stays that of the active area.
    pub fn part(&self, PixelArea { x, y, width, height }: PixelArea) -> Self {
        let (samples, row_length) = (self.cfa.samples_per_pixel(), self.row_length());
        let rows = self.data.chunks(row_length.max(1)).skip(y).take(height);
        Self {
            width,
            height,
            data: rows.flat_map(|row| &row[x * samples..(x + width) * samples]).copied().collect(),
            cfa: self.cfa.from(x, y),
            active_area: None,
            bits: self.bits,
            linearisation: self.linearisation.clone(),
            black_level_dn: self.black_level_dn.from(&self.cfa, x, y),
            white_level_dn: self.white_level_dn,
            channel_whites_dn: self.channel_whites_dn.clone(),
            metadata: RawMetadata { default_crop: None, ..self.metadata.clone() },
        }
    }
}

/// Bits that a value of `maximum` needs.
fn bits_for(maximum: u16) -> u32 {
    (u16::BITS - maximum.leading_zeros()).max(8)
}

/// Replaces values by those of a table; the last entry stands for all beyond.
fn linearise(data: &mut [u16], table: &[u16]) {
    if let Some(&last) = table.last() {
        data.par_iter_mut().for_each(|dn| *dn = table.get(usize::from(*dn)).copied().unwrap_or(last));
    }
}

/// Metadata of a raw image: its exposure, its optics and the meaning of its colours.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RawMetadata {
    /// Sensor preset or name.
    pub camera_model: String,
    /// Serial number of the camera; empty where it is not known.
    pub camera_serial: String,
    /// Pixel pitch along x and y, m.
    pub pixel_pitch_m: Option<[f64; 2]>,
    /// Whether every second row of the active area, from its second on, lies half a pixel farther to the right, as those
    /// of hexagonal cells do.
    pub is_staggered: bool,
    /// Width of a pixel over its height, where a file says another than its pitch does, which EXIF may round.
    pub stated_pixel_aspect: Option<f64>,
    /// Exposure time, s.
    pub exposure_time_s: f64,
    /// Saturation-based ISO speed, where it is known.
    pub iso: Option<u32>,
    /// f-number, where there is a lens.
    pub f_number: Option<f64>,
    /// Focal length, m.
    pub focal_length_m: Option<f64>,
    /// Colour calibrations in up to three lights, in the order of DNG files; none where they are not known or the
    /// channels have no colours.
    pub calibrations: Vec<ColourCalibration>,
    /// The camera's response to the scene's white, per channel, the largest 1; `None` for monochrome.
    pub as_shot_neutral: Option<Vec<f64>>,
    /// CIE x and y of the scene's white, where that is what a file says in place of the camera's response to it.
    pub as_shot_white_xy: Option<[f64; 2]>,
    /// Per channel (S, O): variance of the normalised signal x in 0–1 is S·x + O (DNG NoiseProfile).
    pub noise_profile: Vec<[f64; 2]>,
    /// Exposure compensation by which a developer brightens the image unasked, so that it looks as it should, EV (DNG
    /// BaselineExposure).
    pub baseline_exposure_ev: f64,
    /// Changes of pixel values, in their order: of stored values, of linear ones (gains that undo the lens's falloff, where
    /// it is known: one map for all pixels, or one for each of some), of demosaicked ones (DNG OpcodeList1, 2, 3).
    pub opcodes: [Vec<Opcode>; 3],
    /// The part of the active area that a developer shows (DNG DefaultCropOrigin and DefaultCropSize); `None` for all.
    pub default_crop: Option<PixelArea>,
    /// The lens's distortion, where it is known.
    pub distortion: Option<Distortion>,
    /// Orientation: the turn by which the image stands upright.
    pub orientation: Orientation,
    /// Warnings about statements of the file that nothing follows.
    pub left_out: Vec<String>,
}

impl RawMetadata {
    /// Width of a pixel over its height; pixels are taken for square where nothing is known of them.
    pub fn pixel_aspect(&self) -> f64 {
        let aspect = self.stated_pixel_aspect.or(self.pixel_pitch_m.map(|[x, y]| x / y)).unwrap_or(1.0);
        // What no pixel can be is damage.
        let aspect = if (0.01..=100.0).contains(&aspect) { aspect } else { 1.0 };
        // No pixel is known as well as that, and a file that rounds a pitch must not make another image.
        (aspect * 1e12).round() / 1e12
    }

    /// Gain maps of linear values.
    pub fn gain_maps(&self) -> impl Iterator<Item = &GainMap> {
        self.opcodes[1].iter().filter_map(|opcode| if let Opcode::GainMap(map) = opcode { Some(map) } else { None })
    }

    /// Whether a file says nothing that a developer could use.
    pub fn is_silent(&self) -> bool {
        Self { orientation: Orientation::default(), left_out: Vec::new(), ..self.clone() } == Self::default()
    }

    /// XYZ → camera for colours under D65, where it is known.
    pub fn colour_matrix_d65(&self) -> Option<&Vec<[f64; 3]>> {
        let of_d65 = self.calibrations.iter().find(|calibration| calibration.light == LightSource::D65);
        of_d65.map(|calibration| &calibration.colour_matrix)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::projection::{BrownConrady, Intrinsics, Projection};

    #[test]
    fn all_but_the_numbers_survives_serialisation() {
        let cfa = Cfa::parse("x-trans").expect("known");
        let black = BlackLevel::of_tile(2, vec![63.9, 64.1]).expect("a tile");
        let lens = LensModel {
            intrinsics: Intrinsics { fx: 1.1, fy: 1.2, cx: 0.1, cy: 0.2, skew: 1e-17 },
            projection: Projection::Omnidirectional { xi: 0.7, distortion: BrownConrady::default() },
            max_angle_rad: Some(0.1 + 0.2),
        };
        let calibration = ColourCalibration {
            light: LightSource::D65,
            colour_matrix: vec![[1.0 / 3.0, 2.0, -1e-9]; 3],
            forward_matrix: None,
        };
        let raw = RawImage {
            width: 6,
            height: 1,
            data: vec![7; 6],
            active_area: Some(PixelArea { x: 1, y: 0, width: 5, height: 1 }),
            linearisation: Some(vec![0, 3, 9]),
            black_level_dn: black.with_deltas(&cfa, vec![0.1; 6], Vec::new()),
            cfa,
            metadata: RawMetadata {
                camera_model: "a \"camera\"".to_owned(),
                calibrations: vec![calibration],
                opcodes: [vec![], vec![Opcode::GainMap(GainMap::new(2, 1, vec![1.0, 1.1]).expect("a map"))], vec![]],
                distortion: Some(Distortion::Lens(lens)),
                ..RawMetadata::default()
            },
            ..RawImage::default()
        };
        let text = serde_json::to_string(&raw).expect("plain values");
        let read: RawImage = serde_json::from_str(&text).expect("what was written");
        assert!(read.data.is_empty());
        assert_eq!(read.with_data(vec![7; 6]), raw);
    }
}
