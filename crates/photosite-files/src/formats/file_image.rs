//! Image on its way into a file, of any format.

use std::borrow::Cow;
use std::io;

use rayon::prelude::*;

use crate::icc::icc_profile;
use crate::stated_colours::StatedColours;
use photosite_core::colour::{ColourSpace, Transfer};
use photosite_core::image::Planes;
use photosite_develop::{Codes, DevelopSettings, EncodedImage};

/// Image on its way into a file: its pixel values, and statements that formats make which have a place for them.
#[derive(Clone, Debug)]
pub struct FileImage<'a> {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Number of channels.
    pub channels: usize,
    /// Pixel values.
    pub samples: Samples<'a>,
    /// Largest integer that there could be.
    pub largest: u16,
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
    /// Statements of colours, and attributes of EXR files; formats make those that they have a place for.
    pub colours: Cow<'a, StatedColours>,
    /// Description of floats that are no colours.
    pub description: Option<String>,
    /// Quality of a JPEG file, 1 to 100.
    pub jpeg_quality: u8,
    /// Whether PNG files are compressed with little effort, which on noise gains a few percent and takes several times
    /// as long.
    pub is_fast: bool,
}

/// Pixel values.
#[derive(Clone, Debug)]
pub enum Samples<'a> {
    /// Integers of 8 bits, interleaved by pixel.
    U8(Cow<'a, [u8]>),
    /// Integers of 16 bits, interleaved by pixel.
    U16(Cow<'a, [u16]>),
    /// Floats, a plane for each channel.
    F32(Cow<'a, Planes>),
}

impl<'a> FileImage<'a> {
    /// Pixel values of which nothing is stated.
    pub fn plain(size: [usize; 2], channels: usize, samples: Samples<'a>) -> Self {
        let largest = if matches!(samples, Samples::U8(_)) { u8::MAX.into() } else { u16::MAX };
        Self {
            size,
            channels,
            samples,
            largest,
            pixel_aspect: 1.0,
            colours: Cow::default(),
            description: None,
            jpeg_quality: DevelopSettings::default().jpeg_quality,
            is_fast: false,
        }
    }

    /// Floats of which nothing is stated.
    pub fn of_planes(planes: &'a Planes) -> Self {
        let size = [planes.width(), planes.height()];
        Self::plain(size, planes.channels().len(), Samples::F32(Cow::Borrowed(planes)))
    }

    /// Codes for display, whose colours are stated by an ICC profile and where they can be by code points.
    pub fn of_codes(image: &'a EncodedImage) -> Self {
        let samples = match &image.codes {
            Codes::U8(codes) => Samples::U8(Cow::Borrowed(codes)),
            Codes::U16(codes) => Samples::U16(Cow::Borrowed(codes)),
        };
        let profile = Some(icc_profile(image));
        let colours = StatedColours { profile, code_points: code_points(image), ..StatedColours::default() };
        Self {
            pixel_aspect: image.pixel_aspect,
            colours: Cow::Owned(colours),
            is_fast: true,
            ..Self::plain([image.width, image.height], image.components, samples)
        }
    }

    /// Columns and rows, as encoders take them.
    pub(super) fn sides(&self) -> io::Result<[u32; 2]> {
        let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
        Ok([side(self.size[0])?, side(self.size[1])?])
    }

    /// Integers as bytes, those of 16 bits with the most significant first.
    pub(super) fn big_endian(&self) -> io::Result<Cow<'_, [u8]>> {
        match &self.samples {
            Samples::U8(codes) => Ok(Cow::Borrowed(codes)),
            Samples::U16(codes) => {
                let mut bytes = vec![0; 2 * codes.len()];
                bytes.as_chunks_mut().0.par_iter_mut().zip(&**codes).for_each(|(to, code)| *to = code.to_be_bytes());
                Ok(Cow::Owned(bytes))
            }
            Samples::F32(_) => Err(io::Error::other("floating-point values are no integers")),
        }
    }

    /// Numbers of pixels across and down that have equal lengths; `None` for square pixels.
    pub(super) fn not_square(&self) -> Option<[u32; 2]> {
        (self.pixel_aspect != 1.0).then(|| [(1e6 / self.pixel_aspect).round() as u32, 1_000_000])
    }
}

/// Code points of primaries and transfer function in H.273; `None` where one of them has none.
fn code_points(image: &EncodedImage) -> Option<[u8; 2]> {
    let primaries = match image.colour_space {
        ColourSpace::Srgb => 1,
        ColourSpace::DisplayP3 => 12,
        ColourSpace::Rec2020 => 9,
        ColourSpace::Acescg | ColourSpace::Xyz => return None,
    };
    let transfer = match image.transfer {
        Transfer::Srgb => 13,
        Transfer::Linear => 8,
        Transfer::Gamma(2.2) => 4,
        Transfer::Gamma(2.8) => 5,
        Transfer::Gamma(_) => return None,
    };
    Some([primaries, transfer])
}
