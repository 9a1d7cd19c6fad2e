//! The header of an EXR file with its attributes in one order.

use std::io::{self, Seek, SeekFrom, Write};
use std::mem;

/// Bytes before the attributes: magic number and version.
const START: usize = 8;

/// Writer that passes on a one-part file with the attributes of its header sorted by name. The library keeps them in a
/// hash map, whose order differs from run to run; their order means nothing, and their length stays.
pub(super) struct SortedHeader<W> {
    /// Bytes of the header so far, until it is whole.
    header: Option<Vec<u8>>,
    to: W,
}

impl<W> SortedHeader<W> {
    pub(super) fn new(to: W) -> Self {
        Self { header: Some(Vec::new()), to }
    }
}

impl<W: Write> Write for SortedHeader<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let Some(header) = &mut self.header else { return self.to.write(bytes) };
        header.extend(bytes);
        if let Some(sorted) = sorted(header) {
            self.header = None;
            self.to.write_all(&sorted)?;
        }
        Ok(bytes.len())
    }

    /// Flushes all bytes so far, including an unfinished header.
    fn flush(&mut self) -> io::Result<()> {
        if let Some(header) = &mut self.header {
            self.to.write_all(&mem::take(header))?;
        }
        self.to.flush()
    }
}

impl<W: Seek> Seek for SortedHeader<W> {
    /// Seeks behind the header; only bytes there can be written again.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match (&self.header, to) {
            (None, _) => self.to.seek(to),
            (Some(header), SeekFrom::Current(0)) => Ok(self.to.stream_position()? + header.len() as u64),
            (Some(_), _) => Err(io::Error::other("a header is written from its start to its end")),
        }
    }
}

/// All bytes so far, with the attributes sorted; `None` before the list of attributes has ended.
fn sorted(file: &[u8]) -> Option<Vec<u8>> {
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut at = START;
    while *file.get(at)? != 0 {
        let length = attribute_length(&file[at..])?;
        attributes.push(file.get(at..at + length)?);
        at += length;
    }
    attributes.sort();
    Some([&file[..START], &attributes.concat(), &file[at..]].concat())
}

/// Length of the attribute that the bytes begin with: a name and a type, each closed by a zero, the number of bytes of
/// the value as 32 bits, and the value. `None` where it does not end with these bytes.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let type_start = bytes.iter().position(|&b| b == 0)? + 1;
    let size_start = type_start + bytes[type_start..].iter().position(|&b| b == 0)? + 1;
    let size = bytes.get(size_start..size_start + 4)?.try_into().ok().map(u32::from_le_bytes)?;
    Some(size_start + 4 + size as usize)
}
