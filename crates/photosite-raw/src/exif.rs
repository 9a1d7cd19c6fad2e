//! EXIF blocks of images other than DNG.

use std::io::Cursor;

use tiff::tags::Tag;

use super::Orientation;
use super::openable::open;
use super::tag;
use super::tags::Tags;

/// Statements of an EXIF block about pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exif {
    /// Orientation: the turn by which the image stands upright.
    pub orientation: Orientation,
    /// ColorSpace: 1 for sRGB, 2 for Adobe RGB, 65 535 for others.
    pub colour_space: Option<u16>,
}

impl Exif {
    /// Reads a block, which begins as TIFF files do; a damaged one counts as empty.
    pub fn read(block: &[u8]) -> Self {
        let mut block = Cursor::new(block);
        let Ok((decoder, first)) = open(&mut block) else { return Self::default() };
        let mut file = Tags { decoder };
        let Ok(main) = file.decoder.read_directory(first) else { return Self::default() };
        let orientation = file.number(&main, Tag::Orientation).ok().flatten().and_then(Orientation::of_number);
        let exif = file.value(&main, Tag::ExifDirectory).ok().flatten();
        let exif = exif.and_then(|pointer| pointer.into_ifd_pointer().ok());
        let exif = exif.and_then(|pointer| file.decoder.read_directory(pointer).ok());
        let colour_space = exif.and_then(|exif| file.number(&exif, tag::COLOR_SPACE).ok().flatten());
        Self { orientation: orientation.unwrap_or_default(), colour_space: colour_space.map(|number| number as u16) }
    }
}
