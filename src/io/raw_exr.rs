//! Raw pictures as OpenEXR: the digital numbers as 32-bit floats, which hold those of 16 bits exactly.
//!
//! The planes are those that [`read_picture_file`](super::picture_file::read_picture_file) makes of any raw file: `raw`, or
//! one for each channel where every pixel has all. Attributes: `unit` "DN", `cfa`, `blackLevel` (the mean), `whiteLevel`.

use std::io::{self, Seek, Write};

use super::exr::{Attribute, write_exr};
use crate::raw::RawImage;
use crate::validation::Picture;

/// Writes an EXR file. The picture must have pixels.
pub fn write_raw_exr<W: Write + Seek>(raw: &RawImage, to: W) -> io::Result<()> {
    let attributes = [
        ("unit", Attribute::Text("DN".to_owned())),
        ("cfa", Attribute::Text(raw.cfa.to_string())),
        ("blackLevel", Attribute::Number(raw.black_level_dn.mean().into())),
        ("whiteLevel", Attribute::Number(raw.white_level_dn.into())),
    ];
    write_exr(&Picture::from_raw(String::new(), raw.clone()).mean, &attributes, to)
}
