//! The mosaic as a NumPy array of `uint16`, shape (rows, columns).

use std::io::{self, Write};

use npyz::WriterBuilder;

use super::RawImage;

/// Writes an NPY file.
pub fn write_npy<W: Write>(raw: &RawImage, to: W) -> io::Result<()> {
    let shape = [raw.height as u64, raw.width as u64];
    let mut array = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(to).begin_nd()?;
    array.extend(raw.data.iter().copied())?;
    array.finish()
}
