//! Pixel values of a DNG file: in one strip as they are, or compressed in tiles.

use std::io::{self, Seek, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use photosite_core::keys::Keys;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tiff::TiffResult;
use tiff::encoder::Rational;
use tiff::tags::{PhotometricInterpretation, PlanarConfiguration, Tag};

use super::ifd::{Ifd, align};
use crate::tag;
use crate::thumbnail::Thumbnail;
use crate::{RawImage, lossless_jpeg};

/// Storage of the numbers of a DNG file, always without loss.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum DngCompression {
    /// 16 bits each.
    #[default]
    None,
    /// Bits without gaps, for each number as many as the largest needs.
    Packed,
    /// Lossless JPEG, which every developer reads.
    LosslessJpeg,
    /// zlib. DNG allows it for floating-point numbers and not for those of 16 bits, so they are written as such; some
    /// developers then scale them to a range of their own.
    Deflate,
}

/// Quality of previews, 1–100.
const PREVIEW_QUALITY: u8 = 85;
/// Most pixels along a side of a tile.
const TILE: usize = 512;
/// TIFF wants the sides of tiles to be multiples of this.
const TILE_STEP: usize = 16;

pub(super) fn write<W: Write + Seek>(
    raw: &RawImage,
    compression: DngCompression,
    ifd: &mut Ifd<'_, W>,
) -> TiffResult<()> {
    let samples = raw.cfa.samples_per_pixel();
    let photometric = if raw.cfa.is_mono() || raw.cfa.is_full() { tag::LINEAR_RAW } else { tag::COLOR_FILTER_ARRAY };
    match compression {
        DngCompression::None => {
            let bytes = 2 * raw.data.len();
            write_strip(ifd, [raw.width, raw.height], 16, samples, photometric, &raw.data[..], bytes)
        }
        DngCompression::Packed => {
            let bits = bits_needed(raw);
            let bytes = packed(&raw.data, raw.row_length(), bits);
            write_strip(ifd, [raw.width, raw.height], bits, samples, photometric, &bytes[..], bytes.len())
        }
        DngCompression::LosslessJpeg => {
            write_tiles(raw, ifd, |numbers, row_length| {
                // The like of a pixel in a mosaic is the one after the next.
                let pairs = !raw.cfa.is_mono() && !raw.cfa.is_full() && row_length.is_multiple_of(2);
                Ok(lossless_jpeg::encode(numbers, row_length, if pairs { 2 } else { samples }))
            })?;
            write_tags(ifd, [raw.width, raw.height], 16, samples, photometric, tag::JPEG)
        }
        DngCompression::Deflate => {
            write_tiles(raw, ifd, |numbers, row_length| deflated(numbers, row_length, samples))?;
            ifd.write_tag(Tag::SampleFormat, &vec![tag::FLOAT; samples][..])?;
            ifd.write_tag(Tag::Predictor, tag::FLOATING_POINT)?;
            write_tags(ifd, [raw.width, raw.height], 32, samples, photometric, tag::DEFLATE)
        }
    }
}

pub(super) fn write_thumbnail<W: Write + Seek>(thumbnail: &Thumbnail, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let rgb = PhotometricInterpretation::RGB.to_u16();
    let size = [thumbnail.width, thumbnail.height];
    write_strip(ifd, size, 8, 3, rgb, &thumbnail.rgb[..], thumbnail.rgb.len())
}

/// An image as JPEG in sRGB.
pub(super) fn write_preview<W: Write + Seek>(preview: &Thumbnail, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let (width, height) = (u32::try_from(preview.width)?, u32::try_from(preview.height)?);
    let mut jpeg = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut jpeg, PREVIEW_QUALITY);
    encoder.write_image(&preview.rgb, width, height, ExtendedColorType::Rgb8).map_err(io::Error::other)?;
    ifd.write_tag(Tag::NewSubfileType, tag::REDUCED)?;
    let size = [preview.width, preview.height];
    write_strip(ifd, size, 8, 3, PhotometricInterpretation::YCbCr.to_u16(), &jpeg[..], jpeg.len())?;
    ifd.write_tag(Tag::Compression, tag::JPEG)?;
    // As many numbers of colour as of light, in the middle of the pixel; both with their full range.
    ifd.write_tag(tag::YCBCR_SUBSAMPLING, &[1u16, 1][..])?;
    ifd.write_tag(tag::YCBCR_POSITIONING, 1u16)?;
    let range = [0, 255, 128, 255, 128, 255].map(|n| Rational { n, d: 1 });
    ifd.write_tag(tag::REFERENCE_BLACK_WHITE, &range[..])?;
    ifd.write_tag(tag::PREVIEW_COLOR_SPACE, tag::SRGB)
}

/// Bits that hold every number, and as many as the converter has.
fn bits_needed(raw: &RawImage) -> u16 {
    let largest = raw.data.par_iter().copied().max().unwrap_or(0);
    // dcraw takes 8 bits without a mosaic for an image that was developed already.
    let least = if raw.cfa.is_mono() || raw.cfa.is_full() { 9 } else { 8 };
    (u16::BITS - largest.leading_zeros()).max(raw.bits).clamp(least, 16) as u16
}

/// Packs rows of values of `bits` bits, the most significant bit first; each row begins with a byte. 16 bits are in the
/// order of the machine, which is that of the file.
fn packed(numbers: &[u16], row_length: usize, bits: u16) -> Vec<u8> {
    let bits = usize::from(bits);
    let row_bytes = (row_length * bits).div_ceil(8);
    let mut bytes = vec![0; row_bytes * (numbers.len() / row_length)];
    bytes.par_chunks_exact_mut(row_bytes).zip(numbers.par_chunks_exact(row_length)).for_each(|(to, row)| {
        if bits == 16 {
            to.as_chunks_mut().0.iter_mut().zip(row).for_each(|(to, number)| *to = number.to_ne_bytes());
            return;
        }
        let (mut waiting, mut count) = (0u32, 0);
        let mut to = to.iter_mut();
        for &number in row {
            waiting = waiting << bits | u32::from(number);
            count += bits;
            while count >= 8 {
                count -= 8;
                to.by_ref().take(1).for_each(|byte| *byte = (waiting >> count) as u8);
            }
        }
        // What is left is filled up with zeros.
        to.for_each(|byte| *byte = (waiting << (8 - count)) as u8);
    });
    bytes
}

/// Writes the pixels in one uncompressed strip of `bytes` bytes.
fn write_strip<W: Write + Seek, T: ?Sized>(
    ifd: &mut Ifd<'_, W>,
    [width, height]: [usize; 2],
    bits: u16,
    samples: usize,
    photometric: u16,
    pixels: &T,
    bytes: usize,
) -> TiffResult<()>
where
    for<'t> &'t T: tiff::encoder::TiffValue,
{
    let offset = ifd.write_data(pixels)?;
    align(ifd, bytes)?;
    ifd.write_tag(Tag::StripOffsets, u32::try_from(offset)?)?;
    ifd.write_tag(Tag::StripByteCounts, u32::try_from(bytes)?)?;
    ifd.write_tag(Tag::RowsPerStrip, u32::try_from(height)?)?;
    write_tags(ifd, [width, height], bits, samples, photometric, tag::UNCOMPRESSED)
}

/// Writes the pixels in tiles, each coded by itself from its values and the length of its rows.
///
/// LibRaw and dcraw take a tile that is wider than the image for a strip, so images that are smaller than the
/// smallest tile become a strip.
fn write_tiles<W: Write + Seek>(
    raw: &RawImage,
    ifd: &mut Ifd<'_, W>,
    code: impl Fn(&[u16], usize) -> io::Result<Vec<u8>> + Sync,
) -> TiffResult<()> {
    if raw.width < TILE_STEP || raw.height < TILE_STEP {
        let strip = code(&raw.data, raw.row_length())?;
        let offset = ifd.write_data(&strip[..])?;
        align(ifd, strip.len())?;
        ifd.write_tag(Tag::StripOffsets, u32::try_from(offset)?)?;
        ifd.write_tag(Tag::StripByteCounts, u32::try_from(strip.len())?)?;
        return ifd.write_tag(Tag::RowsPerStrip, u32::try_from(raw.height)?);
    }
    let [tile_width, tile_height] = [raw.width, raw.height].map(|n| (n / TILE_STEP * TILE_STEP).min(TILE));
    let [across, down] = [raw.width.div_ceil(tile_width), raw.height.div_ceil(tile_height)];
    let (samples, row_length) = (raw.cfa.samples_per_pixel(), raw.row_length());
    let coded = |tile: usize| {
        let (left, top) = (tile % across * tile_width, tile / across * tile_height);
        let mut numbers = Vec::with_capacity(tile_width * tile_height * samples);
        for y in top..top + tile_height {
            let row = &raw.data[y.min(raw.height - 1) * row_length..][..row_length];
            // Beyond the edge the last two pixels repeat, which keeps the mosaic's phase and costs little.
            let inside = row_length.min((left + tile_width) * samples) - left * samples;
            numbers.extend(&row[left * samples..][..inside]);
            let step = (2 * samples).min(inside);
            for _ in inside..tile_width * samples {
                numbers.push(numbers[numbers.len() - step]);
            }
        }
        code(&numbers, tile_width * samples)
    };
    let tiles: Vec<Vec<u8>> = (0..across * down).into_par_iter().map(coded).collect::<io::Result<_>>()?;
    let (mut offsets, mut lengths) = (Vec::new(), Vec::new());
    for tile in &tiles {
        offsets.push(u32::try_from(ifd.write_data(&tile[..])?)?);
        lengths.push(u32::try_from(tile.len())?);
        align(ifd, tile.len())?;
    }
    ifd.write_tag(Tag::TileWidth, u32::try_from(tile_width)?)?;
    ifd.write_tag(Tag::TileLength, u32::try_from(tile_height)?)?;
    ifd.write_tag(Tag::TileOffsets, &offsets[..])?;
    ifd.write_tag(Tag::TileByteCounts, &lengths[..])
}

/// Writes the tags that TIFF requires of any image.
fn write_tags<W: Write + Seek>(
    ifd: &mut Ifd<'_, W>,
    [width, height]: [usize; 2],
    bits: u16,
    samples: usize,
    photometric: u16,
    compression: u16,
) -> TiffResult<()> {
    ifd.write_tag(Tag::ImageWidth, u32::try_from(width)?)?;
    ifd.write_tag(Tag::ImageLength, u32::try_from(height)?)?;
    ifd.write_tag(Tag::BitsPerSample, &vec![bits; samples][..])?;
    ifd.write_tag(Tag::Compression, compression)?;
    ifd.write_tag(Tag::PhotometricInterpretation, photometric)?;
    ifd.write_tag(Tag::SamplesPerPixel, u16::try_from(samples)?)?;
    ifd.write_tag(Tag::PlanarConfiguration, PlanarConfiguration::Chunky.to_u16())
}

/// The numbers as floating-point ones, with differences taken as the predictor wants it (Adobe's TIFF Technical Note
/// 3): of each row the first bytes of all numbers, then the second, third and fourth ones, each less that of the pixel
/// before.
fn deflated(numbers: &[u16], row_length: usize, samples: usize) -> io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    for row in numbers.chunks_exact(row_length) {
        let mut bytes = vec![0; 4 * row_length];
        for (x, &number) in row.iter().enumerate() {
            for (i, byte) in f32::from(number).to_be_bytes().into_iter().enumerate() {
                bytes[i * row_length + x] = byte;
            }
        }
        for i in (samples..bytes.len()).rev() {
            bytes[i] = bytes[i].wrapping_sub(bytes[i - samples]);
        }
        encoder.write_all(&bytes)?;
    }
    encoder.finish()
}
