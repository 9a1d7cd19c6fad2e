//! PNG files of plain values, which say nothing of colours: ground truth, masks, and images for tools that want grey.

use std::io::{self, Write};
use std::path::Path;

use image::DynamicImage;

use super::formats::{FileImage, Samples, png};
use photosite_core::input;
use photosite_core::{Error, Result};
use photosite_scene_io::{decode, dimensions};

/// Image of 8-bit grey.
#[derive(Clone, Debug, PartialEq)]
pub struct GreyImage {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Values, row by row from the top-left pixel.
    pub values: Vec<u8>,
}

/// Reads an image of any kind as 8-bit grey: colours by the luma of Rec. 709, 16 bits by their upper byte.
pub fn read_grey(path: &Path) -> Result<GreyImage> {
    let grey = open(path)?.into_luma8();
    Ok(GreyImage { size: [grey.width(), grey.height()], values: grey.into_raw() })
}

/// Whether an image has no colours.
pub fn is_grey(path: &Path) -> Result<bool> {
    Ok(!open(path)?.color().has_color())
}

/// Columns and rows of an image.
pub fn image_size(path: &Path) -> Result<[u32; 2]> {
    let bytes = input::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    dimensions(&bytes).map_err(|e| Error::in_file(path, "", format!("is not an image: {e}")))
}

fn open(path: &Path) -> Result<DynamicImage> {
    let bytes = input::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    decode(&bytes, &path.display().to_string()).map_err(|invalid| invalid.in_file(path))
}

/// Writes an 8-bit grey PNG file.
pub fn write_grey8<W: Write>(size: [u32; 2], values: &[u8], to: W) -> io::Result<()> {
    write_png_of_numbers(size, 1, Samples::U8(values.into()), to)
}

/// Writes an 8-bit RGB PNG file.
pub fn write_rgb8<W: Write>(size: [u32; 2], values: &[u8], to: W) -> io::Result<()> {
    write_png_of_numbers(size, 3, Samples::U8(values.into()), to)
}

/// Writes a 16-bit grey PNG file.
pub fn write_grey16<W: Write>(size: [u32; 2], values: &[u16], to: W) -> io::Result<()> {
    write_png_of_numbers(size, 1, Samples::U16(values.into()), to)
}

fn write_png_of_numbers<W: Write>(size: [u32; 2], channels: usize, samples: Samples<'_>, to: W) -> io::Result<()> {
    png::write(&FileImage::plain(size.map(|n| n as usize), channels, samples), to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
        write_grey16([3, 1], &[0, 258, 65_535], &mut file).expect("written");
        let wide = open(file.path()).expect("an image").into_luma16();
        assert_eq!(wide.as_raw(), &[0, 258, 65_535]);
        let image = read_grey(file.path()).expect("an image");
        assert_eq!(image, GreyImage { size: [3, 1], values: vec![0, 1, 255] });
        assert!(is_grey(file.path()).expect("an image"));
    }
}
