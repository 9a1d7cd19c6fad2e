//! A way round the TIFF library, which opens no file whose first image it cannot decode, as mosaics in the first
//! directory are: it is shown an image of one grey pixel first, and the true first directory is asked for by its
//! place.

use std::io::{self, Read, Seek, SeekFrom};

use tiff::decoder::Decoder;
use tiff::tags::IfdPointer;
use tiff::{TiffError, TiffFormatError, TiffResult};

/// Layout of a TIFF file: offsets of 32 bits, or of 64 (BigTIFF), and the order of bytes.
#[derive(Clone, Copy)]
struct Layout {
    is_big: bool,
    is_big_endian: bool,
}

impl Layout {
    /// Bytes before the place of the first directory.
    fn first(self) -> usize {
        if self.is_big { 8 } else { 4 }
    }

    /// Offset at which the directory of the grey pixel seems to be: near the last that such a file can point to, well
    /// beyond the end of others.
    fn far(self) -> u64 {
        if self.is_big { i64::MAX as u64 - 0xfff } else { u64::from(u32::MAX) - 0xff }
    }

    /// The lowest bytes of a number.
    fn bytes(self, number: u64, count: usize) -> Vec<u8> {
        if self.is_big_endian {
            number.to_be_bytes().into_iter().skip(8 - count).collect()
        } else {
            number.to_le_bytes().into_iter().take(count).collect()
        }
    }

    fn number(self, bytes: &[u8]) -> u64 {
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        if self.is_big_endian { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) }
    }

    /// Bytes of a place, and of a count in a directory's entry.
    fn place(self) -> usize {
        if self.is_big { 8 } else { 4 }
    }

    /// A directory of one grey pixel.
    fn directory(self) -> Vec<u8> {
        // Width, height, bits, compression, grey, strip offset, its length: one short number each.
        let entries = [(256, 1), (257, 1), (258, 8), (259, 1), (262, 1), (273, 8), (279, 1)];
        let mut directory = self.bytes(entries.len() as u64, if self.is_big { 8 } else { 2 });
        for (tag, value) in entries {
            directory.extend([self.bytes(tag, 2), self.bytes(3, 2), self.bytes(1, self.place())].concat());
            directory.extend(self.bytes(value, 2));
            directory.extend(vec![0; self.place() - 2]);
        }
        directory.extend(self.bytes(0, self.place()));
        directory
    }
}

/// Source of a TIFF file, of any kind: the library is compiled once.
pub(super) trait ReadSeek: Read + Seek {}

impl<R: Read + Seek> ReadSeek for R {}

/// The file with another first directory far behind its end.
pub(super) struct Openable<'a> {
    from: &'a mut dyn ReadSeek,
    /// The place of `from`.
    from_position: u64,
    length: u64,
    position: u64,
    /// The file's beginning, in which the place of the first directory is another.
    header: Vec<u8>,
    /// Offset at which that directory seems to be.
    far: u64,
    directory: Vec<u8>,
}

/// Opens a TIFF or BigTIFF file whatever its images are, or a camera profile, which is a TIFF file of another magic
/// number. Also where its first directory is.
pub(super) fn open(from: &mut dyn ReadSeek) -> TiffResult<(Decoder<Openable<'_>>, IfdPointer)> {
    let length = from.seek(SeekFrom::End(0))?;
    from.rewind()?;
    let mut magic = [0; 4];
    from.read_exact(&mut magic)?;
    match &magic {
        b"IIRC" => magic = *b"II*\0",
        b"MMCR" => magic = *b"MM\0*",
        _ => {}
    }
    let layout = match &magic {
        b"II*\0" => Layout { is_big: false, is_big_endian: false },
        b"MM\0*" => Layout { is_big: false, is_big_endian: true },
        b"II+\0" => Layout { is_big: true, is_big_endian: false },
        b"MM\0+" => Layout { is_big: true, is_big_endian: true },
        _ => return Err(TiffError::FormatError(TiffFormatError::TiffSignatureNotFound)),
    };
    let mut header = magic.to_vec();
    let whole = layout.first() + layout.place();
    Read::take(&mut *from, (whole - header.len()) as u64).read_to_end(&mut header)?;
    if header.len() < whole {
        return Err(TiffError::IoError(io::ErrorKind::UnexpectedEof.into()));
    }
    let place = layout.number(&header[layout.first()..]);
    let far = layout.far();
    if length > far {
        return Err(TiffError::LimitsExceeded);
    }
    header.truncate(layout.first());
    header.extend(layout.bytes(far, layout.place()));
    let from_position = header.len() as u64;
    let openable = Openable { from, from_position, length, position: 0, header, far, directory: layout.directory() };
    Ok((Decoder::new(openable)?, IfdPointer(place)))
}

impl Read for Openable<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let mut in_memory = |bytes: &[u8], first: u64| -> usize {
            let bytes = usize::try_from(first).ok().and_then(|first| bytes.get(first..)).unwrap_or_default();
            let count = bytes.len().min(to.len());
            to[..count].copy_from_slice(&bytes[..count]);
            count
        };
        let count = if self.position < self.header.len() as u64 {
            in_memory(&self.header, self.position)
        } else if self.position >= self.far {
            in_memory(&self.directory, self.position - self.far)
        } else {
            if self.from_position != self.position {
                self.from_position = self.from.seek(SeekFrom::Start(self.position))?;
            }
            let count = self.from.read(to)?;
            self.from_position += count as u64;
            count
        };
        self.position += count as u64;
        Ok(count)
    }
}

impl Seek for Openable<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
            SeekFrom::End(offset) => self.length.checked_add_signed(offset),
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}
