//! PNG files of plain numbers, which say nothing of colours: ground truth, masks, and pictures for tools that want
//! grey.

use std::io::{self, Write};
use std::path::Path;

use image::DynamicImage;
use png::{BitDepth, ColorType};

use crate::{Error, Result};
use photosite_core::input;
use photosite_scene_io::{decode, dimensions};

/// A picture of 8-bit grey.
#[derive(Clone, Debug, PartialEq)]
pub struct GreyPicture {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Row by row from the top-left pixel.
    pub values: Vec<u8>,
}

/// Reads a picture of any kind as grey of 8 bits: colours by the luma of Rec. 709, 16 bits by their upper half.
pub fn read_grey(path: &Path) -> Result<GreyPicture> {
    let grey = open(path)?.into_luma8();
    Ok(GreyPicture { size: [grey.width(), grey.height()], values: grey.into_raw() })
}

/// Whether a picture has no colours.
pub fn is_grey(path: &Path) -> Result<bool> {
    Ok(!open(path)?.color().has_color())
}

/// Columns and rows of a picture.
pub fn picture_size(path: &Path) -> Result<[u32; 2]> {
    let bytes = input::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    dimensions(&bytes).map_err(|e| Error::in_file(path, "", format!("is not a picture: {e}")))
}

fn open(path: &Path) -> Result<DynamicImage> {
    let bytes = input::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    decode(&bytes, &path.display().to_string()).map_err(|invalid| invalid.in_file(path))
}

/// Writes 8-bit grey.
pub fn write_grey8<W: Write>(size: [u32; 2], values: &[u8], to: W) -> io::Result<()> {
    write_png_of_numbers(size, ColorType::Grayscale, BitDepth::Eight, values, to)
}

/// Writes 8-bit RGB.
pub fn write_rgb8<W: Write>(size: [u32; 2], values: &[u8], to: W) -> io::Result<()> {
    write_png_of_numbers(size, ColorType::Rgb, BitDepth::Eight, values, to)
}

/// Writes 16-bit grey.
pub fn write_grey16<W: Write>(size: [u32; 2], values: &[u16], to: W) -> io::Result<()> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
    write_png_of_numbers(size, ColorType::Grayscale, BitDepth::Sixteen, &bytes, to)
}

/// Writes numbers as PNG files have them: row by row, those of 16 bits with their upper half first.
pub(super) fn write_png_of_numbers<W: Write>(
    [width, height]: [u32; 2],
    kind: ColorType,
    depth: BitDepth,
    bytes: &[u8],
    to: W,
) -> io::Result<()> {
    let mut info = png::Info::with_size(width, height);
    (info.color_type, info.bit_depth) = (kind, depth);
    let mut writer = png::Encoder::with_info(to, info)?.write_header()?;
    writer.write_image_data(bytes)?;
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
        write_grey16([3, 1], &[0, 258, 65_535], &mut file).expect("written");
        let wide = open(file.path()).expect("a picture").into_luma16();
        assert_eq!(wide.as_raw(), &[0, 258, 65_535]);
        let picture = read_grey(file.path()).expect("a picture");
        assert_eq!(picture, GreyPicture { size: [3, 1], values: vec![0, 1, 255] });
        assert!(is_grey(file.path()).expect("a picture"));
    }
}
