//! The digital numbers of a DNG file, from strips or tiles, whatever they are coded in.
//!
//! Memory is taken only for numbers that the bytes which are there can hold, whatever a damaged file states.

use std::borrow::Cow;
use std::io::{Read, Seek, SeekFrom};

use flate2::read::ZlibDecoder;
use rayon::prelude::*;
use tiff::Directory;
use tiff::tags::{ByteOrder, Tag};

use crate::tag;
use crate::tags::{Tags, unreadable};
use crate::{check_memory, lossless_jpeg};
use photosite_core::Invalid;

/// Pixel values of an image.
pub(super) enum PixelValues {
    /// Digital numbers.
    Whole(Vec<u16>),
    /// Floating-point values.
    Floats(Vec<f32>),
}

/// Coding of the numbers in the bytes of a strip or tile.
pub(super) struct Coding {
    compression: u16,
    bits: usize,
    is_float: bool,
    predictor: u16,
    samples: usize,
    byte_order: ByteOrder,
}

/// Bytes of which zlib can make no more than this for each.
const MOST_INFLATION: usize = 1032;

impl Coding {
    pub(super) fn read(file: &mut Tags<'_>, image: &Directory, samples: usize) -> Result<Self, Invalid> {
        let all_bits = file.numbers(image, Tag::BitsPerSample)?;
        let mut number = |tag: Tag, default: f64| file.number(image, tag).map(|n| n.unwrap_or(default));
        let bits = all_bits.first().copied().unwrap_or(1.0);
        let coding = Self {
            compression: number(Tag::Compression, 1.0)? as u16,
            bits: bits as usize,
            is_float: number(Tag::SampleFormat, 1.0)? == f64::from(tag::FLOAT),
            predictor: number(Tag::Predictor, 1.0)? as u16,
            samples,
            byte_order: file.decoder.byte_order(),
        };
        let planar = file.number(image, Tag::PlanarConfiguration)?.unwrap_or(1.0);
        let format = file.number(image, Tag::SampleFormat)?.unwrap_or(1.0);
        let predictors: &[u16] = match (coding.compression, coding.is_float) {
            (tag::UNCOMPRESSED | tag::JPEG, _) => &[1],
            (_, false) => &[1, tag::HORIZONTAL],
            (_, true) => &[1, tag::FLOATING_POINT, tag::FLOATING_POINT_X2, tag::FLOATING_POINT_X4],
        };
        let known_bits = match (coding.compression, coding.is_float) {
            (tag::UNCOMPRESSED, false) => (8..=16).contains(&coding.bits),
            (tag::JPEG, false) => (2..=16).contains(&coding.bits),
            (tag::DEFLATE, false) => [8, 16].contains(&coding.bits),
            (_, true) => [16, 24, 32].contains(&coding.bits),
            // Of another compression nothing is known.
            (_, false) => true,
        };
        let refused = |key: &str, message: String, help: &str| Err(Invalid::new(key, message).help(help));
        let name = if coding.is_float { "floating-point numbers" } else { "numbers" };
        if ![tag::UNCOMPRESSED, tag::JPEG, tag::DEFLATE].contains(&coding.compression)
            || (coding.is_float && coding.compression == tag::JPEG)
        {
            let message = format!("{name} are compressed as {}", compression_name(coding.compression));
            let help =
                "write it uncompressed, as lossless JPEG or with Deflate, for example with Adobe's DNG Converter";
            return refused("Compression", message, help);
        }
        if ![1.0, f64::from(tag::FLOAT)].contains(&format) {
            let message = format!("numbers of the format {format}, with a sign or of no kind");
            return refused("SampleFormat", message, "photosite reads whole numbers from 0 up and floating-point ones");
        }
        if !known_bits || all_bits.iter().any(|other| *other != bits) {
            let message = format!("{name} of {all_bits:?} bits");
            return refused(
                "BitsPerSample",
                message,
                "photosite reads 8 to 16 bits, or floating-point ones of 16, 24 or 32",
            );
        }
        // Lossless JPEG has predictors of its own.
        if coding.compression != tag::JPEG && !predictors.contains(&coding.predictor) {
            let message = format!("{name} with the predictor {}", coding.predictor);
            return refused("Predictor", message, "write it without a predictor");
        }
        if planar != 1.0 && samples > 1 {
            let message = "the file holds one plane after the other".to_owned();
            return refused("PlanarConfiguration", message, "write all numbers of a pixel together");
        }
        Ok(coding)
    }

    /// width × height pixels.
    pub(super) fn numbers(
        &self,
        file: &mut Tags<'_>,
        image: &Directory,
        size: [usize; 2],
    ) -> Result<PixelValues, Invalid> {
        if self.is_float {
            self.joined(file, image, size, Self::decode_floats).map(PixelValues::Floats)
        } else {
            self.joined(file, image, size, Self::decode).map(PixelValues::Whole)
        }
    }

    /// Joins the values of all strips or tiles.
    fn joined<T: Copy + Default + Send + Sync>(
        &self,
        file: &mut Tags<'_>,
        image: &Directory,
        [width, height]: [usize; 2],
        decode: impl Fn(&Self, &[u8], usize, usize) -> Result<Vec<T>, String> + Sync,
    ) -> Result<Vec<T>, Invalid> {
        let samples = self.samples;
        let (tile_width, tile_height, offsets, lengths) = if file.number(image, Tag::TileWidth)?.is_some() {
            let side = |side: Option<f64>| side.filter(|n| (1.0..=65_535.0).contains(n)).map(|n| n as usize);
            let tile_width = side(file.number(image, Tag::TileWidth)?);
            let tile_height = side(file.number(image, Tag::TileLength)?);
            let Some((tile_width, tile_height)) = tile_width.zip(tile_height) else {
                return Err(Invalid::new("TileWidth", "tiles without width or height").help("the file is damaged"));
            };
            (tile_width, tile_height, Tag::TileOffsets, Tag::TileByteCounts)
        } else {
            let rows = file.number(image, Tag::RowsPerStrip)?.unwrap_or(f64::MAX).clamp(1.0, height as f64);
            (width, rows as usize, Tag::StripOffsets, Tag::StripByteCounts)
        };
        let is_tiled = matches!(offsets, Tag::TileOffsets);
        let [offsets, lengths] = [offsets, lengths].map(|tag| file.numbers(image, tag));
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
            if bytes_there > self.most_bytes(across * tile_width * down * tile_height * samples) {
                return Err(
                    Invalid::new("StripByteCounts", "more bytes than the pixels need").help("the file is damaged")
                );
            }
        }
        let row_length = width * samples;
        if self.most_numbers(bytes_there) < row_length * height {
            let message = format!("{bytes_there} bytes cannot hold {width} × {height} pixels");
            return Err(Invalid::new("StripByteCounts", message).help("the file is truncated or damaged"));
        }
        check_memory([width, height], samples)?;
        let mut data = vec![T::default(); row_length * height];
        // A row of tiles at a time, so that those that are decoded already take little memory.
        for (y, (rows, parts)) in data.chunks_mut(row_length * tile_height).zip(parts.chunks(across)).enumerate() {
            let rows_here = if is_tiled { tile_height } else { rows.len() / row_length };
            let decoded: Vec<Vec<T>> = parts
                .par_iter()
                .map(|bytes| decode(self, bytes, tile_width * samples, rows_here))
                .collect::<Result<_, _>>()
                .map_err(|complaint| {
                    let message = format!("the image from row {} on: {complaint}", y * tile_height);
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

    /// The white level of a file that does not say it.
    pub(super) fn default_white(&self) -> f64 {
        if self.is_float { 1.0 } else { 2f64.powi(self.bits as i32) - 1.0 }
    }

    /// Largest number of values that `bytes` bytes can hold.
    fn most_numbers(&self, bytes: usize) -> usize {
        match self.compression {
            // A code has one bit at least.
            tag::JPEG => bytes.saturating_mul(8),
            tag::DEFLATE => bytes.saturating_mul(MOST_INFLATION) / (self.bits / 8),
            _ => bytes.saturating_mul(8) / self.bits,
        }
    }

    /// Largest number of bytes that `numbers` values can need, with headers.
    fn most_bytes(&self, numbers: usize) -> usize {
        numbers.saturating_mul(5).saturating_add(1 << 20)
    }

    /// Decodes the values of a strip or tile.
    fn decode(&self, bytes: &[u8], row_length: usize, rows: usize) -> Result<Vec<u16>, String> {
        let count = row_length * rows;
        if self.most_numbers(bytes.len()) < count {
            return Err("it is truncated".to_owned());
        }
        match self.compression {
            tag::JPEG => lossless_jpeg::decode(bytes, count),
            _ => self.plain(&self.inflated(bytes, count)?, row_length, rows),
        }
    }

    /// Decodes the floating-point values of a strip or tile.
    fn decode_floats(&self, bytes: &[u8], row_length: usize, rows: usize) -> Result<Vec<f32>, String> {
        if self.most_numbers(bytes.len()) < row_length * rows {
            return Err("it is truncated".to_owned());
        }
        let mut bytes = self.inflated(bytes, row_length * rows)?.into_owned();
        let size = self.bits / 8;
        let all = bytes.get_mut(..row_length * size * rows).ok_or("it is truncated")?;
        let stride = match self.predictor {
            tag::FLOATING_POINT => self.samples,
            tag::FLOATING_POINT_X2 => 2 * self.samples,
            tag::FLOATING_POINT_X4 => 4 * self.samples,
            _ => 0,
        };
        let mut numbers = Vec::with_capacity(row_length * rows);
        for row in all.chunks_exact_mut((row_length * size).max(1)) {
            for i in stride..if stride == 0 { 0 } else { row.len() } {
                row[i] = row[i].wrapping_add(row[i - stride]);
            }
            // The most significant byte first; behind a predictor those of all numbers together.
            let byte = |x: usize, i: usize| match (stride, self.byte_order) {
                (0, ByteOrder::LittleEndian) => row[size * x + size - 1 - i],
                (0, ByteOrder::BigEndian) => row[size * x + i],
                _ => row[i * row_length + x],
            };
            let bits = |x: usize| (0..size).fold(0, |sum, i| sum << 8 | u32::from(byte(x, i)));
            numbers.extend((0..row_length).map(|x| float_of(bits(x), self.bits)));
        }
        Ok(numbers)
    }

    /// Inflates the bytes of `count` values.
    fn inflated<'a>(&self, bytes: &'a [u8], count: usize) -> Result<Cow<'a, [u8]>, String> {
        if self.compression != tag::DEFLATE {
            return Ok(Cow::Borrowed(bytes));
        }
        let mut inflated = Vec::new();
        let size = (count * self.bits / 8) as u64;
        ZlibDecoder::new(bytes).take(size).read_to_end(&mut inflated).map_err(|error| error.to_string())?;
        Ok(Cow::Owned(inflated))
    }

    /// Reads values that are not compressed, or no longer.
    fn plain(&self, bytes: &[u8], row_length: usize, rows: usize) -> Result<Vec<u16>, String> {
        let row_bytes = (row_length * self.bits).div_ceil(8);
        let bytes = bytes.get(..row_bytes * rows).ok_or("it is truncated")?;
        let mut numbers = Vec::with_capacity(row_length * rows);
        for row in bytes.chunks_exact(row_bytes.max(1)) {
            let first = numbers.len();
            match (self.bits, self.byte_order) {
                (8, _) => numbers.extend(row.iter().map(|&byte| u16::from(byte))),
                (16, ByteOrder::LittleEndian) => {
                    numbers.extend(row.as_chunks().0.iter().map(|&b| u16::from_le_bytes(b)))
                }
                (16, ByteOrder::BigEndian) => numbers.extend(row.as_chunks().0.iter().map(|&b| u16::from_be_bytes(b))),
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

/// Name of a compression by its number in a file.
fn compression_name(compression: u16) -> String {
    match compression {
        1 => "none".to_owned(),
        5 => "LZW".to_owned(),
        7 => "JPEG".to_owned(),
        34892 => "lossy JPEG".to_owned(),
        50002 | 52546 => "JPEG XL".to_owned(),
        other => format!("number {other}"),
    }
}

/// A floating-point number of 16 or 32 bits (IEEE 754), or of DNG's 24: a sign, 7 bits of exponent with a bias of 63, 16
/// of fraction.
fn float_of(bits: u32, count: usize) -> f32 {
    let (exponent_bits, fraction_bits) = match count {
        16 => (5, 10),
        24 => (7, 16),
        _ => return f32::from_bits(bits),
    };
    let fraction = f64::from(bits & ((1 << fraction_bits) - 1)) / f64::from(1u32 << fraction_bits);
    let exponent = (bits >> fraction_bits & ((1 << exponent_bits) - 1)) as i32;
    let largest = (1 << exponent_bits) - 1;
    let bias = largest / 2;
    let magnitude = match exponent {
        0 => fraction * 2f64.powi(1 - bias),
        _ if exponent == largest && fraction == 0.0 => f64::INFINITY,
        _ if exponent == largest => f64::NAN,
        _ => (1.0 + fraction) * 2f64.powi(exponent - bias),
    };
    (if bits >> (count - 1) & 1 == 1 { -magnitude } else { magnitude }) as f32
}

/// Value x of a row of values of 9–15 bits without gaps, the most significant bit first.
fn packed(row: &[u8], x: usize, bits: usize) -> u16 {
    let first = x * bits;
    let bytes = (0..3).fold(0u32, |sum, i| sum << 8 | u32::from(row.get(first / 8 + i).copied().unwrap_or(0)));
    (bytes >> (24 - first % 8 - bits) & ((1 << bits) - 1)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_of_fewer_bits_are_those_of_the_specification() {
        // 1, −2, 0.5, the smallest of 16 bits, infinity, by hand.
        for (bits, count, expected) in [
            (0x3c00, 16, 1.0),
            (0xc000, 16, -2.0),
            (0x3800, 16, 0.5),
            (0x0001, 16, 2f32.powi(-24)),
            (0x3555, 16, 0.333_251_95),
            (0x7c00, 16, f32::INFINITY),
            (0x3f_0000, 24, 1.0),
            (0xc0_0000, 24, -2.0),
            (0x3e_8000, 24, 0.75),
            (0x00_0001, 24, 2f32.powi(-78)),
            (0x3f80_0000, 32, 1.0),
        ] {
            assert_eq!(float_of(bits, count), expected, "{bits:#x} of {count}");
        }
        assert!(float_of(0x7c01, 16).is_nan() && float_of(0x7f_0001, 24).is_nan());
    }

    #[test]
    fn packed_numbers_lie_without_gaps() {
        // 0xabc, 0xdef, 0x123 in 12 bits; the same bits as numbers of 9.
        let row = [0xab, 0xcd, 0xef, 0x12, 0x30];
        assert_eq!([0, 1, 2].map(|x| packed(&row, x, 12)), [0xabc, 0xdef, 0x123]);
        assert_eq!([0, 1, 2].map(|x| packed(&row, x, 9)), [0b1_0101_0111, 0b1_0011_0111, 0b1_0111_1000]);
    }
}
