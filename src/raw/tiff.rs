//! 16-bit TIFF, grey for a mosaic and RGB where every pixel has three channels: the digital numbers as they are, nothing
//! else.

use std::io::{self, Seek, Write};

use tiff::TiffError;
use tiff::encoder::{
    TiffEncoder,
    colortype::{Gray16, RGB16},
};

use super::RawImage;

/// Writes a 16-bit TIFF file.
pub fn write_tiff<W: Write + Seek>(raw: &RawImage, to: W) -> io::Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let (width, height) = (side(raw.width)?, side(raw.height)?);
    let write = || {
        let mut file = TiffEncoder::new(to)?;
        match raw.cfa.samples_per_pixel() {
            1 => file.write_image::<Gray16>(width, height, &raw.data),
            3 => file.write_image::<RGB16>(width, height, &raw.data),
            other => Err(io::Error::other(format!("pixels of {other} numbers cannot be written as TIFF")).into()),
        }
    };
    write().map_err(io_error)
}

/// What went wrong below the TIFF library, or what it found fault with.
pub(super) fn io_error(error: TiffError) -> io::Error {
    let TiffError::IoError(error) = error else { return io::Error::other(error) };
    error
}
