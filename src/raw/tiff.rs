//! 16-bit TIFF, grey for a mosaic and RGB where every pixel has three channels: the digital numbers as they are, nothing
//! else.

use std::io::{self, Read, Seek, SeekFrom, Write};

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::encoder::{
    TiffEncoder,
    colortype::{Gray16, RGB16},
};
use tiff::tags::{CompressionMethod, PhotometricInterpretation, PlanarConfiguration, Tag};
use tiff::{TiffError, TiffResult};

use super::{Cfa, MAX_SIDE, RawImage};
use crate::Invalid;

/// Bytes of which zlib can make no more than this for each, nor any other compression of TIFF.
const MOST_INFLATION: usize = 1032;

/// Writes a 16-bit TIFF file.
pub fn write_tiff<W: Write + Seek>(raw: &RawImage, to: W) -> io::Result<()> {
    write(raw, to).map_err(io_error)
}

fn write<W: Write + Seek>(raw: &RawImage, to: W) -> TiffResult<()> {
    let (width, height) = (u32::try_from(raw.width)?, u32::try_from(raw.height)?);
    let mut file = TiffEncoder::new(to)?;
    match raw.cfa.samples_per_pixel() {
        1 => file.write_image::<Gray16>(width, height, &raw.data),
        3 => file.write_image::<RGB16>(width, height, &raw.data),
        samples => {
            let mut ifd = file.image_directory()?;
            let offset = ifd.write_data(&raw.data[..])?;
            ifd.write_tag(Tag::ImageWidth, width)?;
            ifd.write_tag(Tag::ImageLength, height)?;
            ifd.write_tag(Tag::BitsPerSample, &vec![16u16; samples][..])?;
            ifd.write_tag(Tag::Compression, CompressionMethod::None.to_u16())?;
            ifd.write_tag(Tag::PhotometricInterpretation, PhotometricInterpretation::BlackIsZero.to_u16())?;
            ifd.write_tag(Tag::StripOffsets, u32::try_from(offset)?)?;
            ifd.write_tag(Tag::StripByteCounts, u32::try_from(2 * raw.data.len())?)?;
            ifd.write_tag(Tag::RowsPerStrip, height)?;
            ifd.write_tag(Tag::SamplesPerPixel, u16::try_from(samples)?)?;
            ifd.write_tag(Tag::PlanarConfiguration, PlanarConfiguration::Chunky.to_u16())?;
            // What goes beyond grey has no name in TIFF.
            ifd.write_tag(Tag::ExtraSamples, &vec![0u16; samples - 1][..])?;
            ifd.finish()
        }
    }
}

/// Reads a 16-bit TIFF file of grey as the numbers of a monochrome sensor, and of three components as RGB: nothing in it
/// says more.
pub fn read_tiff<R: Read + Seek>(mut from: R) -> Result<RawImage, Invalid> {
    let unreadable = |error: TiffError| Invalid::new("", format!("cannot read it as TIFF: {error}"));
    let length = from.seek(SeekFrom::End(0)).and_then(|length| from.rewind().map(|()| length));
    let length = length.map_err(|error| unreadable(error.into()))?;
    let mut decoder = Decoder::new(from).map_err(unreadable)?;
    let (width, height) = decoder.dimensions().map_err(unreadable)?;
    let (width, height) = (width as usize, height as usize);
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(Invalid::new("ImageWidth", format!("{width} × {height} pixels are not a picture")));
    }
    // Memory is taken for numbers that the bytes which are there can hold, whatever a damaged file states.
    let compression = decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(unreadable)?;
    let inflation = if compression.is_none_or(|c| c == CompressionMethod::None.to_u16()) { 1 } else { MOST_INFLATION };
    let samples = decoder.colortype().map_err(unreadable)?.num_samples();
    let most = usize::try_from(length).unwrap_or(usize::MAX).saturating_mul(inflation);
    if 2 * width * height * usize::from(samples) > most {
        let message = format!("{length} bytes cannot hold {width} × {height} pixels");
        return Err(Invalid::new("StripByteCounts", message).help("the file is cut short or damaged"));
    }
    let mut limits = Limits::default();
    limits.decoding_buffer_size = limits.decoding_buffer_size.max(most);
    let mut decoder = decoder.with_limits(limits);
    let DecodingResult::U16(data) = decoder.read_image().map_err(unreadable)? else {
        return Err(Invalid::new("BitsPerSample", "the file does not hold 16-bit numbers"));
    };
    let cfa = match data.len() / (width * height) {
        1 => Cfa::mono(),
        3 => Cfa::full(["R", "G", "B"])?,
        other => {
            let message = format!("the file holds {other} numbers a pixel");
            return Err(Invalid::new("SamplesPerPixel", message).help("photosite reads grey and RGB"));
        }
    };
    if data.len() != width * height * cfa.samples_per_pixel() {
        return Err(Invalid::new("StripByteCounts", "the file does not hold all pixels"));
    }
    Ok(RawImage::bare(width, height, data, cfa, u16::MAX))
}

/// What went wrong below the TIFF library, or what it found fault with.
pub(super) fn io_error(error: TiffError) -> io::Error {
    let TiffError::IoError(error) = error else { return io::Error::other(error) };
    error
}
