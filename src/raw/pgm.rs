//! The mosaic as binary PGM of 16 bits, most significant byte first.

use std::io::{self, Write};

use super::RawImage;

/// Writes a PGM file. Its maximum is 65535 whatever the converter's bits, so that no reader rescales the numbers.
pub fn write_pgm<W: Write>(raw: &RawImage, mut to: W) -> io::Result<()> {
    write!(to, "P5\n{} {}\n65535\n", raw.width, raw.height)?;
    let mut row_bytes = Vec::with_capacity(2 * raw.width);
    for row in raw.data.chunks(raw.width.max(1)) {
        row_bytes.clear();
        row_bytes.extend(row.iter().flat_map(|dn| dn.to_be_bytes()));
        to.write_all(&row_bytes)?;
    }
    Ok(())
}
