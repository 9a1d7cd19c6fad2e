//! Directories of tags, and values that keep to even offsets.

use std::io::{Seek, Write};

use tiff::encoder::{DirectoryEncoder, TiffKindStandard};
use tiff::tags::{Tag, Type};
use tiff::{Directory, TiffResult};

/// A directory that is being written.
pub(super) type Ifd<'a, W> = DirectoryEncoder<'a, W, TiffKindStandard>;

/// Bytes of the type UNDEFINED.
pub(super) fn write_undefined<W: Write + Seek>(ifd: &mut Ifd<'_, W>, tag: Tag, bytes: &[u8]) -> TiffResult<()> {
    let entry = ifd.write_entry_bytes(Type::UNDEFINED, bytes)?;
    let mut undefined = Directory::empty();
    undefined.extend([(tag, entry)]);
    ifd.extend_from(&undefined);
    pad(ifd, bytes.len())
}

/// Text, which in TIFF is ASCII without zeros, followed by one.
pub(super) fn write_text<W: Write + Seek>(ifd: &mut Ifd<'_, W>, tag: Tag, text: &str) -> TiffResult<()> {
    let ascii: String = text.chars().map(|c| if c.is_ascii() && !c.is_ascii_control() { c } else { '?' }).collect();
    ifd.write_tag(tag, ascii.as_str())?;
    pad(ifd, ascii.len() + 1)
}

/// After a tag's value, of which up to 4 bytes lie in the directory itself.
pub(super) fn pad<W: Write + Seek>(ifd: &mut Ifd<'_, W>, bytes_written: usize) -> TiffResult<()> {
    if bytes_written > 4 { align(ifd, bytes_written) } else { Ok(()) }
}

/// Pads to an even offset, at which the next block must begin (TIFF 6.0, p. 15).
pub(super) fn align<W: Write + Seek>(ifd: &mut Ifd<'_, W>, bytes_written: usize) -> TiffResult<()> {
    if bytes_written % 2 == 1 {
        ifd.write_data(0u8)?;
    }
    Ok(())
}
