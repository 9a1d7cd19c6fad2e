//! The digital numbers of a DNG file, from strips or tiles, whatever they are coded in.
//!
//! Memory is taken only for numbers that the bytes which are there can hold, whatever a damaged file states.

use std::io::{Read, Seek, SeekFrom};

use flate2::read::ZlibDecoder;
use rayon::prelude::*;
use tiff::Directory;
use tiff::tags::{ByteOrder, Tag};

use super::tag;
use super::tags::{Tags, unreadable};
use crate::raw::{check_memory, lossless_jpeg};
use photosite_core::Invalid;

/// How numbers lie in the bytes of a strip or tile.
struct Coding {
    compression: u16,
    bits: usize,
    is_float: bool,
    predictor: u16,
    samples: usize,
    byte_order: ByteOrder,
}

/// Bytes of which zlib can make no more than this for each.
const MOST_INFLATION: usize = 1032;

/// width × height pixels of `samples` numbers each.
pub(super) fn read<R: Read + Seek>(
    file: &mut Tags<R>,
    picture: &Directory,
    [width, height]: [usize; 2],
    samples: usize,
) -> Result<Vec<u16>, Invalid> {
    let coding = Coding::read(file, picture, samples)?;
    let (tile_width, tile_height, offsets, lengths) = if file.number(picture, Tag::TileWidth)?.is_some() {
        let side = |side: Option<f64>| side.filter(|n| (1.0..=65_535.0).contains(n)).map(|n| n as usize);
        let tile_width = side(file.number(picture, Tag::TileWidth)?);
        let tile_height = side(file.number(picture, Tag::TileLength)?);
        let Some((tile_width, tile_height)) = tile_width.zip(tile_height) else {
            return Err(Invalid::new("TileWidth", "tiles without width or height").help("the file is damaged"));
        };
        (tile_width, tile_height, Tag::TileOffsets, Tag::TileByteCounts)
    } else {
        let rows = file.number(picture, Tag::RowsPerStrip)?.unwrap_or(f64::MAX).clamp(1.0, height as f64);
        (width, rows as usize, Tag::StripOffsets, Tag::StripByteCounts)
    };
    let is_tiled = matches!(offsets, Tag::TileOffsets);
    let [offsets, lengths] = [offsets, lengths].map(|tag| file.numbers(picture, tag));
    let (offsets, lengths) = (offsets?, lengths?);
    let (across, down) = (width.div_ceil(tile_width), height.div_ceil(tile_height));
    if offsets.len() != across * down || lengths.len() != offsets.len() {
        let message = format!("{} parts instead of {}", offsets.len(), across * down);
        return Err(Invalid::new("StripOffsets", message).help("the file is damaged"));
    }

    let mut parts = Vec::new();
    let mut bytes_there = 0usize;
    for (&offset, &length) in offsets.iter().zip(&lengths) {
        let mut bytes = Vec::new();
        let reader = file.decoder.inner();
        let read = reader
            .seek(SeekFrom::Start(offset as u64))
            .and_then(|_| reader.take(length as u64).read_to_end(&mut bytes));
        read.map_err(|error| unreadable(error.into()))?;
        bytes_there += bytes.len();
        parts.push(bytes);
        // Parts that lie over each other could be many.
        if bytes_there > coding.most_bytes(across * tile_width * down * tile_height * samples) {
            return Err(Invalid::new("StripByteCounts", "more bytes than the pixels need").help("the file is damaged"));
        }
    }
    let row_length = width * samples;
    if coding.most_numbers(bytes_there) < row_length * height {
        let message = format!("{bytes_there} bytes cannot hold {width} × {height} pixels");
        return Err(Invalid::new("StripByteCounts", message).help("the file is truncated or damaged"));
    }
    check_memory([width, height], samples)?;
    let mut data = vec![0; row_length * height];
    // A row of tiles at a time, so that those that are decoded already take little memory.
    for (y, (rows, parts)) in data.chunks_mut(row_length * tile_height).zip(parts.chunks(across)).enumerate() {
        let rows_here = if is_tiled { tile_height } else { rows.len() / row_length };
        let decoded: Vec<Vec<u16>> = parts
            .par_iter()
            .map(|bytes| coding.decode(bytes, tile_width * samples, rows_here))
            .collect::<Result<_, _>>()
            .map_err(|complaint| {
                let message = format!("the picture from row {} on: {complaint}", y * tile_height);
                Invalid::new("", message)
                    .help("the file is truncated or damaged, or of a kind that photosite cannot read")
            })?;
        for (row, numbers) in rows.chunks_mut(row_length).enumerate() {
            for (to, part) in numbers.chunks_mut(tile_width * samples).zip(&decoded) {
                to.copy_from_slice(&part[row * tile_width * samples..][..to.len()]);
            }
        }
    }
    Ok(data)
}

impl Coding {
    fn read<R: Read + Seek>(file: &mut Tags<R>, picture: &Directory, samples: usize) -> Result<Self, Invalid> {
        let all_bits = file.numbers(picture, Tag::BitsPerSample)?;
        let mut number = |tag: Tag, default: f64| file.number(picture, tag).map(|n| n.unwrap_or(default));
        let bits = all_bits.first().copied().unwrap_or(1.0);
        let coding = Self {
            compression: number(Tag::Compression, 1.0)? as u16,
            bits: bits as usize,
            is_float: number(Tag::SampleFormat, 1.0)? == f64::from(tag::FLOAT),
            predictor: number(Tag::Predictor, 1.0)? as u16,
            samples,
            byte_order: file.decoder.byte_order(),
        };
        let planar = file.number(picture, Tag::PlanarConfiguration)?.unwrap_or(1.0);
        let known = match (coding.compression, coding.is_float) {
            (tag::UNCOMPRESSED, false) => (8..=16).contains(&coding.bits),
            (tag::JPEG, false) => (2..=16).contains(&coding.bits),
            (tag::DEFLATE, false) => [8, 16].contains(&coding.bits) && [1, tag::HORIZONTAL].contains(&coding.predictor),
            (tag::UNCOMPRESSED, true) => coding.bits == 32,
            (tag::DEFLATE, true) => coding.bits == 32 && [1, tag::FLOATING_POINT].contains(&coding.predictor),
            _ => false,
        };
        if !known || all_bits.iter().any(|other| *other != bits) || (planar != 1.0 && samples > 1) {
            let message = format!(
                "{} of {bits} bits with compression {} and predictor {} cannot be read",
                if coding.is_float { "floating-point numbers" } else { "numbers" },
                coding.compression,
                coding.predictor
            );
            return Err(Invalid::new("Compression", message).help(
                "write it uncompressed, as lossless JPEG or with Deflate, for example with Adobe's DNG Converter",
            ));
        }
        Ok(coding)
    }

    /// How many numbers so many bytes can hold at most.
    fn most_numbers(&self, bytes: usize) -> usize {
        match self.compression {
            // A code has one bit at least.
            tag::JPEG => bytes.saturating_mul(8),
            tag::DEFLATE => bytes.saturating_mul(MOST_INFLATION) / (self.bits / 8),
            _ => bytes.saturating_mul(8) / self.bits,
        }
    }

    /// How many bytes so many numbers can need, with headers.
    fn most_bytes(&self, numbers: usize) -> usize {
        numbers.saturating_mul(5).saturating_add(1 << 20)
    }

    /// The numbers of a strip or tile.
    fn decode(&self, bytes: &[u8], row_length: usize, rows: usize) -> Result<Vec<u16>, String> {
        let count = row_length * rows;
        if self.most_numbers(bytes.len()) < count {
            return Err("it is truncated".to_owned());
        }
        match self.compression {
            tag::JPEG => lossless_jpeg::decode(bytes, count),
            tag::DEFLATE => {
                let mut inflated = Vec::new();
                let size = count * self.bits / 8;
                ZlibDecoder::new(bytes)
                    .take(size as u64)
                    .read_to_end(&mut inflated)
                    .map_err(|error| error.to_string())?;
                self.plain(&mut inflated, row_length, rows)
            }
            _ => self.plain(&mut bytes.to_vec(), row_length, rows),
        }
    }

    /// Numbers that are not compressed, or no longer.
    fn plain(&self, bytes: &mut [u8], row_length: usize, rows: usize) -> Result<Vec<u16>, String> {
        let row_bytes = (row_length * self.bits).div_ceil(8);
        let bytes = bytes.get_mut(..row_bytes * rows).ok_or("it is truncated")?;
        let mut numbers = Vec::with_capacity(row_length * rows);
        for row in bytes.chunks_exact_mut(row_bytes) {
            if self.predictor == tag::FLOATING_POINT {
                for i in self.samples..row.len() {
                    row[i] = row[i].wrapping_add(row[i - self.samples]);
                }
            }
            let first = numbers.len();
            match (self.bits, self.byte_order) {
                (8, _) => numbers.extend(row.iter().map(|&byte| u16::from(byte))),
                (16, ByteOrder::LittleEndian) => {
                    numbers.extend(row.as_chunks().0.iter().map(|&b| u16::from_le_bytes(b)))
                }
                (16, ByteOrder::BigEndian) => numbers.extend(row.as_chunks().0.iter().map(|&b| u16::from_be_bytes(b))),
                (32, order) => {
                    for x in 0..row_length {
                        let float = if self.predictor == tag::FLOATING_POINT {
                            f32::from_be_bytes([0, 1, 2, 3].map(|i| row[i * row_length + x]))
                        } else {
                            let bytes = [0, 1, 2, 3].map(|i| row[4 * x + i]);
                            match order {
                                ByteOrder::LittleEndian => f32::from_le_bytes(bytes),
                                ByteOrder::BigEndian => f32::from_be_bytes(bytes),
                            }
                        };
                        if !(float.fract() == 0.0 && (0.0..=65_535.0).contains(&float)) {
                            return Err(format!("{float} is not a digital number of 16 bits"));
                        }
                        numbers.push(float as u16);
                    }
                }
                (bits, _) => numbers.extend((0..row_length).map(|x| packed(row, x, bits))),
            }
            if self.predictor == tag::HORIZONTAL {
                let mask = ((1u32 << self.bits) - 1) as u16;
                for i in first + self.samples..numbers.len() {
                    numbers[i] = numbers[i].wrapping_add(numbers[i - self.samples]) & mask;
                }
            }
        }
        Ok(numbers)
    }
}

/// The x-th number of a row of numbers of 9–15 bits without gaps, the most significant bit first.
fn packed(row: &[u8], x: usize, bits: usize) -> u16 {
    let first = x * bits;
    let bytes = (0..3).fold(0u32, |sum, i| sum << 8 | u32::from(row.get(first / 8 + i).copied().unwrap_or(0)));
    (bytes >> (24 - first % 8 - bits) & ((1 << bits) - 1)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_numbers_lie_without_gaps() {
        // 0xabc, 0xdef, 0x123 in 12 bits; the same bits as numbers of 9.
        let row = [0xab, 0xcd, 0xef, 0x12, 0x30];
        assert_eq!([0, 1, 2].map(|x| packed(&row, x, 12)), [0xabc, 0xdef, 0x123]);
        assert_eq!([0, 1, 2].map(|x| packed(&row, x, 9)), [0b1_0101_0111, 0b1_0011_0111, 0b1_0111_1000]);
    }
}
