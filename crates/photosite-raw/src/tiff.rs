//! TIFF, grey for a mosaic and RGB where every pixel has three channels: the digital numbers as they are, nothing else.
//! Written with 16 bits, read with 8 or 16.

use std::io::{self, Read, Seek, SeekFrom, Write};

use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::encoder::{
    TiffEncoder,
    colortype::{Gray16, RGB16},
};
use tiff::tags::{CompressionMethod, PhotometricInterpretation, PlanarConfiguration, Tag};
use tiff::{ColorType, TiffError, TiffResult};

use super::openable::{ReadSeek, open};
use super::rules::{self, Kind};
use super::tags::{self, Tags};
use super::{Cfa, MAX_SIDE, Orientation, RawImage, RawMetadata, check_memory};
use photosite_core::{Invalid, counted};

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

/// Reads a TIFF file of grey as the numbers of a monochrome sensor, and of three components as RGB, unscaled: nothing
/// in it says more. The largest number of its 8 or 16 bits is the white level.
pub fn read_tiff<R: Read + Seek>(mut from: R) -> Result<RawImage, Invalid> {
    read(&mut from)
}

fn read(from: &mut dyn ReadSeek) -> Result<RawImage, Invalid> {
    let unreadable = |error: TiffError| {
        let invalid = Invalid::new("", format!("cannot read it as TIFF: {error}"));
        let is_cut = matches!(&error, TiffError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof);
        let is_unsupported = matches!(&error, TiffError::UnsupportedError(_));
        if is_cut {
            invalid.help("the file is truncated or damaged")
        } else if is_unsupported {
            invalid.help("write it as grey or RGB of 8 or 16 bits, without compression or with LZW or Deflate")
        } else {
            invalid
        }
    };
    let TiffNotes { mut left_out, orientation, profile } = notes(from)?;
    if profile.is_some() {
        left_out.push(
            "ICCProfile is left out: its pixel values are taken for those of a sensor, in proportion to light; write a PNG \
             file of an image that is developed already"
                .to_owned(),
        );
    }
    from.rewind().map_err(|error| unreadable(error.into()))?;
    let length = from.seek(SeekFrom::End(0)).and_then(|length| from.rewind().map(|()| length));
    let length = length.map_err(|error| unreadable(error.into()))?;
    let mut decoder = Decoder::new(from).map_err(unreadable)?;
    let (width, height) = decoder.dimensions().map_err(unreadable)?;
    let (width, height) = (width as usize, height as usize);
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(Invalid::new("ImageWidth", format!("{width} × {height} pixels are not an image")));
    }
    let colours = decoder.colortype().map_err(unreadable)?;
    let (bits, samples) = (colours.bit_depth(), usize::from(colours.num_samples()));
    let cfa = match (colours, samples) {
        (ColorType::Gray(_) | ColorType::Multiband { .. }, 1) => Cfa::mono(),
        (ColorType::RGB(_) | ColorType::Multiband { .. }, 3) => Cfa::full(["R", "G", "B"])?,
        (_, _) => {
            let message = format!("the file holds {samples} values per pixel, of the kind {colours:?}");
            return Err(Invalid::new("SamplesPerPixel", message).help("photosite reads grey and RGB"));
        }
    };
    if ![8, 16].contains(&bits) {
        let message = format!("the file holds numbers of {bits} bits");
        return Err(Invalid::new("BitsPerSample", message).help("photosite reads 8 and 16 bits"));
    }
    refuse_planar_tiles(&mut decoder).map_err(unreadable)??;
    // Memory is taken for numbers that the bytes which are there can hold, whatever a damaged file states.
    let compression = decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(unreadable)?;
    let inflation = if compression.is_none_or(|c| c == CompressionMethod::None.to_u16()) { 1 } else { MOST_INFLATION };
    let most = usize::try_from(length).unwrap_or(usize::MAX).saturating_mul(inflation);
    if usize::from(bits / 8) * width * height * samples > most {
        let message = format!("{length} bytes cannot hold {width} × {height} pixels");
        return Err(Invalid::new("StripByteCounts", message).help("the file is truncated or damaged"));
    }
    check_memory([width, height], samples)?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = limits.decoding_buffer_size.max(most);
    let (data, maximum) = match read_pixels(&mut decoder.with_limits(limits)).map_err(unreadable)? {
        DecodingResult::U8(data) => (data.into_iter().map(u16::from).collect(), u16::from(u8::MAX)),
        DecodingResult::U16(data) => (data, u16::MAX),
        DecodingResult::U32(_)
        | DecodingResult::U64(_)
        | DecodingResult::F16(_)
        | DecodingResult::F32(_)
        | DecodingResult::F64(_)
        | DecodingResult::I8(_)
        | DecodingResult::I16(_)
        | DecodingResult::I32(_)
        | DecodingResult::I64(_) => {
            let message = "the file holds numbers with a sign or a fraction";
            return Err(Invalid::new("SampleFormat", message).help("photosite reads whole numbers from 0 up"));
        }
    };
    if data.len() != width * height * samples {
        return Err(Invalid::new("StripByteCounts", "the file does not hold all pixels"));
    }
    let raw = RawImage::bare(width, height, data, cfa, maximum);
    Ok(RawImage { metadata: RawMetadata { orientation, left_out, ..RawMetadata::default() }, ..raw })
}

/// Statements of a TIFF file beside the pixel values of its first image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TiffNotes {
    /// Warnings about statements of the file that nothing follows.
    pub left_out: Vec<String>,
    /// Orientation: the turn by which the image stands upright.
    pub orientation: Orientation,
    /// ICC profile of the image's colours.
    pub profile: Option<Vec<u8>>,
}

/// Reads the statements of a TIFF file; an error where its pixels are stored as photosite does not read them.
pub fn tiff_notes<R: Read + Seek>(mut from: R) -> Result<TiffNotes, Invalid> {
    notes(&mut from)
}

fn notes(from: &mut dyn ReadSeek) -> Result<TiffNotes, Invalid> {
    let (decoder, first) = open(from).map_err(tags::unreadable)?;
    let mut file = Tags { decoder };
    let pages = file.following(first);
    let Some((page, others)) = pages.split_first() else { return Ok(TiffNotes::default()) };
    let mut left_out = rules::left_out(&mut file, page, Kind::Tiff)?;
    // Smaller images of the same and masks are no pages.
    let mut more = 0;
    for other in others {
        let kind = file.number(other, Tag::NewSubfileType)?.unwrap_or(0.0) as u32;
        more += usize::from(kind & (REDUCED | MASK) == 0);
    }
    if more > 0 {
        left_out.push(format!("{} left out: the first alone is read", be_left(more, "more page", "more pages")));
    }
    // ImageJ writes one directory for all images where they lie one after the other.
    let description = file.text_or_bytes(page, Tag::ImageDescription)?;
    let stacked = description.lines().find_map(|line| line.strip_prefix("images=")?.trim().parse::<usize>().ok());
    if let Some(images) = stacked.filter(|images| description.starts_with("ImageJ=") && *images > 1 && pages.len() == 1)
    {
        left_out.push(format!("{} left out: the first alone is read", be_left(images - 1, "more page", "more pages")));
    }
    let beneath = file.numbers(page, Tag::SubIfd)?.len();
    if beneath > 0 {
        left_out.push(format!("{} left out", be_left(beneath, "image beneath the first", "images beneath the first")));
    }
    let sides = [Tag::XResolution, Tag::YResolution].map(|tag| file.number(page, tag));
    if let [Some(x), Some(y)] = [sides[0].clone()?, sides[1].clone()?]
        && (x / y - 1.0).abs() > 1e-6
        && x * y > 0.0
    {
        left_out.push(format!("XResolution {x} and YResolution {y} are left out: its pixels are taken for square"));
    }
    let orientation = match file.number(page, Tag::Orientation)? {
        None => Orientation::default(),
        Some(number) => Orientation::of_number(number).unwrap_or_else(|| {
            left_out.push(format!("Orientation {number} is none: the image is not turned"));
            Orientation::default()
        }),
    };
    let profile = file.value(page, Tag::IccProfile)?.map(|value| value.into_u8_vec()).transpose();
    let profile = profile.map_err(tags::unreadable)?;
    Ok(TiffNotes { left_out, orientation, profile })
}

/// NewSubfileType of an image of reduced resolution, and of a mask.
const REDUCED: u32 = 1;
const MASK: u32 = 4;

fn be_left(count: usize, one: &str, several: &str) -> String {
    format!("{} {}", counted(count, [one, several]), if count == 1 { "is" } else { "are" })
}

/// Refuses tiles of one plane after the other, which the decoder does not read.
pub fn refuse_planar_tiles<R: Read + Seek>(decoder: &mut Decoder<R>) -> TiffResult<Result<(), Invalid>> {
    let samples = decoder.colortype()?.num_samples();
    if samples < 2 || !planes_apart(decoder)? || decoder.get_chunk_type() != ChunkType::Tile {
        return Ok(Ok(()));
    }
    let invalid = Invalid::new("PlanarConfiguration", "the file holds one plane after the other, in tiles");
    Ok(Err(invalid.help("write strips, or all numbers of a pixel together")))
}

/// Whether a file holds one plane after the other.
fn planes_apart<R: Read + Seek>(decoder: &mut Decoder<R>) -> TiffResult<bool> {
    let planar = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration)?;
    Ok(planar == Some(PlanarConfiguration::Planar.to_u16()))
}

/// Reads the values of an image pixel by pixel, those of files that hold one plane after the other included.
pub fn read_pixels<R: Read + Seek>(decoder: &mut Decoder<R>) -> TiffResult<DecodingResult> {
    let samples = usize::from(decoder.colortype()?.num_samples());
    if samples < 2 || !planes_apart(decoder)? {
        return decoder.read_image();
    }
    let mut planes = DecodingResult::U8(Vec::new());
    decoder.read_image_to_buffer(&mut planes)?;
    Ok(match planes {
        DecodingResult::U8(v) => DecodingResult::U8(interleaved(&v, samples)),
        DecodingResult::U16(v) => DecodingResult::U16(interleaved(&v, samples)),
        DecodingResult::F32(v) => DecodingResult::F32(interleaved(&v, samples)),
        DecodingResult::F64(v) => DecodingResult::F64(interleaved(&v, samples)),
        // No caller takes these.
        other @ (DecodingResult::U32(_)
        | DecodingResult::U64(_)
        | DecodingResult::F16(_)
        | DecodingResult::I8(_)
        | DecodingResult::I16(_)
        | DecodingResult::I32(_)
        | DecodingResult::I64(_)) => other,
    })
}

/// Planes side by side; those that memory did not suffice for are missing.
fn interleaved<T: Copy>(planes: &[T], samples: usize) -> Vec<T> {
    let pixels = planes.len() / samples;
    (0..pixels * samples).map(|i| planes[i % samples * pixels + i / samples]).collect()
}

/// Error of the source below the TIFF library, or one that the library found.
pub(super) fn io_error(error: TiffError) -> io::Error {
    let TiffError::IoError(error) = error else { return io::Error::other(error) };
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A TIFF file of one strip, tag by tag.
    fn file(tags: &[(u16, u16, u32)], pixels: &[u8]) -> Vec<u8> {
        let directory = 8u32;
        let strip = directory + 2 + 12 * (tags.len() as u32 + 2) + 4;
        let mut entries = tags.to_vec();
        entries.extend([(273, 4, strip), (279, 4, pixels.len() as u32)]);
        entries.sort_unstable();
        let mut bytes = [&b"II*\0"[..], &directory.to_le_bytes(), &(entries.len() as u16).to_le_bytes()].concat();
        for (tag, kind, value) in entries {
            bytes.extend(
                [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &1u32.to_le_bytes(), &value.to_le_bytes()].concat(),
            );
        }
        [&bytes, &0u32.to_le_bytes()[..], pixels].concat()
    }

    /// Width, height, bits, compression, photometric interpretation, numbers a pixel, rows of a strip.
    fn tags(width: u32, height: u32, bits: u32, interpretation: u32, samples: u32) -> Vec<(u16, u16, u32)> {
        let rest = [(258, 3, bits), (259, 3, 1), (262, 3, interpretation), (277, 3, samples), (278, 3, height)];
        [&[(256, 3, width), (257, 3, height)][..], &rest].concat()
    }

    fn read(file: &[u8]) -> Result<RawImage, Invalid> {
        read_tiff(io::Cursor::new(file))
    }

    #[test]
    fn eight_bits_stay_as_they_are() {
        let grey = read(&file(&tags(3, 2, 8, 1, 1), &[0, 1, 2, 128, 254, 255])).expect("grey");
        assert_eq!((grey.width, grey.height, grey.data), (3, 2, vec![0, 1, 2, 128, 254, 255]));
        assert_eq!((grey.bits, grey.white_level_dn, grey.cfa), (8, 255, Cfa::mono()));
        let colour = read(&file(&tags(2, 1, 8, 2, 3), &[1, 2, 3, 4, 5, 6])).expect("RGB");
        assert_eq!((colour.data, colour.cfa.channels().len()), (vec![1, 2, 3, 4, 5, 6], 3));
    }

    /// Three planes of one tile each. The decoder would panic.
    #[test]
    fn planes_in_tiles_are_refused() {
        let tags: [(u16, u16, u32, u32); 11] = [
            (256, 3, 1, 5),
            (257, 3, 1, 5),
            (258, 3, 1, 8),
            (259, 3, 1, 1),
            (262, 3, 1, 2),
            (277, 3, 1, 3),
            (284, 3, 1, 2),
            (322, 3, 1, 16),
            (323, 3, 1, 16),
            (324, 4, 3, 146),
            (325, 4, 3, 158),
        ];
        let mut bytes = [&b"II*\0"[..], &8u32.to_le_bytes(), &11u16.to_le_bytes()].concat();
        for (tag, kind, count, value) in tags {
            bytes.extend([&tag.to_le_bytes()[..], &kind.to_le_bytes()].concat());
            bytes.extend([count.to_le_bytes(), value.to_le_bytes()].concat());
        }
        bytes.extend(0u32.to_le_bytes());
        assert_eq!(bytes.len(), 146);
        let places = [170u32, 426, 682, 256, 256, 256].map(u32::to_le_bytes).concat();
        let error = read(&[&bytes[..], &places, &[7; 768]].concat()).expect_err("tiles");
        assert_eq!((error.key.as_str(), error.help.is_some()), ("PlanarConfiguration", true), "{error}");
    }

    #[test]
    fn what_is_no_raw_image_is_refused_by_what_it_is() {
        let float = [&tags(1, 1, 16, 1, 1)[..], &[(339, 3, 3)]].concat();
        for (file, key) in [
            (file(&tags(300, 200, 8, 1, 1), &[0, 1, 2]), "StripByteCounts"),
            (file(&tags(3, 2, 8, 1, 1), &[0, 1, 2]), ""),
            (file(&tags(8, 1, 1, 1, 1), &[0xaa]), "BitsPerSample"),
            (file(&tags(2, 1, 12, 1, 1), &[1, 2, 3]), "BitsPerSample"),
            (file(&tags(1, 1, 8, 5, 4), &[1, 2, 3, 4]), "SamplesPerPixel"),
            (file(&tags(1, 1, 8, 1, 2), &[1, 2]), "SamplesPerPixel"),
            (file(&float, &[1, 2]), "SampleFormat"),
        ] {
            let error = read(&file).expect_err(key);
            assert_eq!((error.key.as_str(), error.help.is_some()), (key, true), "{error}");
        }
    }
}
