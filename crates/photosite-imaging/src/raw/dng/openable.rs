//! A way round the TIFF library, which opens no file whose first picture it cannot decode, as mosaics in the first
//! directory are: it is shown a picture of one grey pixel first, and the true first directory is asked for by its
//! place.

use std::io::{self, Read, Seek, SeekFrom};

use tiff::decoder::Decoder;
use tiff::tags::IfdPointer;
use tiff::{TiffError, TiffFormatError, TiffResult};

/// Where that picture's directory seems to be: the last place that a TIFF file can point to, well beyond the end of
/// others.
const FAR: u32 = u32::MAX - 0xff;

/// The file with another first directory far behind its end.
pub(super) struct Openable<R> {
    from: R,
    /// Where `from` stands.
    from_position: u64,
    length: u64,
    position: u64,
    /// The file's beginning, in which the place of the first directory is another.
    header: [u8; 8],
    directory: Vec<u8>,
}

/// Opens a TIFF file whatever its pictures are. Also where its first directory is.
pub(super) fn open<R: Read + Seek>(mut from: R) -> TiffResult<(Decoder<Openable<R>>, IfdPointer)> {
    let length = from.seek(SeekFrom::End(0))?;
    from.rewind()?;
    let mut header = [0; 8];
    from.read_exact(&mut header)?;
    let [order @ .., a, b, c, d] = header;
    let (is_big_endian, place) = match &order {
        b"II*\0" => (false, u32::from_le_bytes([a, b, c, d])),
        b"MM\0*" => (true, u32::from_be_bytes([a, b, c, d])),
        _ => return Err(TiffError::FormatError(TiffFormatError::TiffSignatureNotFound)),
    };
    let number = |n: u32| if is_big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
    if length > FAR.into() {
        return Err(TiffError::LimitsExceeded);
    }
    header[4..].copy_from_slice(&number(FAR));
    let short = |n: u16| if is_big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
    // Width, height, bits, compression, grey, strip offset, its length: one short number each.
    let entries = [(256, 1), (257, 1), (258, 8), (259, 1), (262, 1), (273, 8), (279, 1)];
    let mut directory = short(entries.len() as u16).to_vec();
    for (tag, value) in entries {
        directory.extend([short(tag), short(3)].as_flattened());
        directory.extend(number(1));
        directory.extend([short(value), short(0)].as_flattened());
    }
    directory.extend(number(0));
    let openable = Openable { from, from_position: 8, length, position: 0, header, directory };
    Ok((Decoder::new(openable)?, IfdPointer(place.into())))
}

impl<R: Read + Seek> Read for Openable<R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let mut in_memory = |bytes: &[u8], first: u64| -> usize {
            let bytes = usize::try_from(first).ok().and_then(|first| bytes.get(first..)).unwrap_or_default();
            let count = bytes.len().min(to.len());
            to[..count].copy_from_slice(&bytes[..count]);
            count
        };
        let count = if self.position < self.header.len() as u64 {
            in_memory(&self.header, self.position)
        } else if self.position >= FAR.into() {
            in_memory(&self.directory, self.position - u64::from(FAR))
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

impl<R> Seek for Openable<R> {
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
