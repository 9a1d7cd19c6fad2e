//! The mosaic as 16-bit grey TIFF: the digital numbers as they are, nothing else.

use std::io::{self, Seek, Write};

use tiff::TiffError;
use tiff::encoder::{TiffEncoder, colortype::Gray16};

use super::RawImage;

/// Writes a 16-bit TIFF file.
pub fn write_tiff<W: Write + Seek>(raw: &RawImage, to: W) -> io::Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let write = || TiffEncoder::new(to)?.write_image::<Gray16>(side(raw.width)?, side(raw.height)?, &raw.data);
    write().map_err(io_error)
}

/// What went wrong below the TIFF library, or what it found fault with.
pub(super) fn io_error(error: TiffError) -> io::Error {
    let TiffError::IoError(error) = error else { return io::Error::other(error) };
    error
}
