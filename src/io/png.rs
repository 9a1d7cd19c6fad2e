//! Developed pictures as PNG files.

use std::io::{self, Write};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

use crate::develop::Picture8;

/// Writes an 8-bit PNG, grey or RGB. The picture must have pixels.
pub fn write_png<W: Write>(picture: &Picture8, to: W) -> io::Result<()> {
    let colour = if picture.components == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let (width, height) = (side(picture.width)?, side(picture.height)?);
    PngEncoder::new(to).write_image(&picture.data, width, height, colour).map_err(|error| {
        let ImageError::IoError(error) = error else { return io::Error::other(error) };
        error
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back_as_they_went() {
        for components in [1, 3] {
            let data: Vec<u8> = (0..5 * 4 * components).map(|i| (i * 13) as u8).collect();
            let picture = Picture8 { width: 5, height: 4, components, data };
            let mut file = Vec::new();
            write_png(&picture, &mut file).expect("written");
            let read = image::load_from_memory(&file).expect("a PNG file");
            assert_eq!((read.width(), read.height()), (5, 4));
            assert_eq!(read.as_bytes(), picture.data);
        }
    }
}
