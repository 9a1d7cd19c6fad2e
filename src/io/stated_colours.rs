//! What a picture's file says of its colours, to be said by another file of the same numbers.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::ImageDecoder;
use image::codecs::jpeg::JpegDecoder;
use tiff::tags::Tag;

use super::exr::{Attribute, read_exr};
use crate::{Error, Invalid, Result};
use photosite_core::input;

/// What a file says besides its numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct StatedColours {
    /// The ICC profile of a PNG, TIFF or JPEG file.
    pub(super) profile: Option<Vec<u8>>,
    /// The attributes of an EXR file.
    pub(super) attributes: Vec<(String, Attribute)>,
    /// What only this kind of file can say.
    pub(super) not_carried: Vec<&'static str>,
}

impl StatedColours {
    /// Of the file at a path; nothing of kinds that say nothing.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let read: fn(BufReader<File>) -> Result<Self, Invalid> = match extension.as_str() {
            "png" => of_png,
            "tif" | "tiff" => |file| Ok(Self { profile: tiff_profile(file)?, ..Self::default() }),
            "jpg" | "jpeg" => |file| Ok(Self { profile: jpeg_profile(file)?, ..Self::default() }),
            "exr" => of_exr,
            _ => return Ok(Self::default()),
        };
        let file = input::open(path).map_err(|source| Error::io(path, "read", source))?;
        read(BufReader::new(file)).map_err(|invalid| invalid.in_file(path))
    }
}

fn of_png(file: BufReader<File>) -> Result<StatedColours, Invalid> {
    let unreadable = |error| Invalid::new("", format!("cannot read it as PNG: {error}"));
    let reader = png::Decoder::new(file).read_info().map_err(unreadable)?;
    let info = reader.info();
    let mut not_carried = Vec::new();
    // Those of sRGB say what a file without them says.
    if info.srgb.is_none() {
        not_carried.extend(info.gama_chunk.map(|_| "gAMA"));
        not_carried.extend(info.chrm_chunk.map(|_| "cHRM"));
    }
    if info.icc_profile.is_none() {
        not_carried.extend(info.coding_independent_code_points.map(|_| "cICP"));
    }
    let profile = info.icc_profile.as_ref().map(|profile| profile.to_vec());
    Ok(StatedColours { profile, not_carried, ..StatedColours::default() })
}

/// The ICC profile of a TIFF file.
pub(super) fn tiff_profile(file: BufReader<File>) -> Result<Option<Vec<u8>>, Invalid> {
    let unreadable = |error| Invalid::new("", format!("cannot read it as TIFF: {error}"));
    let mut decoder = tiff::decoder::Decoder::new(file).map_err(unreadable)?;
    match decoder.find_tag(Tag::IccProfile).map_err(unreadable)? {
        Some(_) => decoder.get_tag_u8_vec(Tag::IccProfile).map(Some).map_err(unreadable),
        None => Ok(None),
    }
}

/// The ICC profile of a JPEG file.
pub(super) fn jpeg_profile(file: BufReader<File>) -> Result<Option<Vec<u8>>, Invalid> {
    let profile = JpegDecoder::new(file).and_then(|mut decoder| decoder.icc_profile());
    profile.map_err(|error| Invalid::new("", format!("cannot read it as JPEG: {error}")))
}

fn of_exr(file: BufReader<File>) -> Result<StatedColours, Invalid> {
    Ok(StatedColours { attributes: read_exr(file)?.attributes, ..StatedColours::default() })
}
