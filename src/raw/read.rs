//! Reading raw files back: the DNG and TIFF files that [`write_dng`](super::write_dng) and
//! [`write_tiff`](super::write_tiff) write, and others like them: one uncompressed plane of 16 bits, Bayer or
//! monochrome. Compressed files of real cameras are left to programs made for them.

use std::io::{Read, Seek, SeekFrom};

use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::{ByteOrder, CompressionMethod, Tag};
use tiff::{Directory, TiffError};

use crate::Invalid;

use super::dng::{COLOR_FILTER_ARRAY, LINEAR_RAW, tag};
use super::{Cfa, RawImage, RawMetadata};

/// Most pixels along a side.
const MAX_SIDE: f64 = 65_535.0;

/// Reads a DNG file.
pub fn read_dng<R: Read + Seek>(from: R) -> Result<RawImage, Invalid> {
    let mut file = Tags { decoder: Decoder::new(from).map_err(unreadable)? };
    let Some(pointer) = file.decoder.ifd_pointer() else { return Err(Invalid::new("", "the file is empty")) };
    let main = file.decoder.read_directory(pointer).map_err(unreadable)?;
    let mosaic = file.find_mosaic(&main)?;
    let [width, height] = [Tag::ImageWidth, Tag::ImageLength].map(|tag| file.number(&mosaic, tag));
    let [width, height] = [width?.unwrap_or(0.0), height?.unwrap_or(0.0)];
    if !(1.0..=MAX_SIDE).contains(&width) || !(1.0..=MAX_SIDE).contains(&height) {
        return Err(Invalid::new("ImageWidth", format!("{width} × {height} pixels are not a picture")));
    }
    let (width, height) = (width as usize, height as usize);
    let data = file.pixels(&mosaic, width * height)?;
    let black = file.number(&mosaic, tag::BLACK_LEVEL)?.unwrap_or(0.0);
    let white = file.number(&mosaic, tag::WHITE_LEVEL)?.unwrap_or(65_535.0);
    if !(0.0..white).contains(&black) || white > 65_535.0 {
        let message = format!("white level {white} and black level {black} leave no range");
        return Err(Invalid::new("WhiteLevel", message));
    }
    // The file does not keep the converter's bits; those that the white level needs are what matters.
    let bits = (u32::BITS - (white as u32).leading_zeros()).max(8);
    Ok(RawImage {
        width,
        height,
        data,
        cfa: file.cfa(&mosaic)?,
        bits,
        black_level_dn: (black as u16).into(),
        white_level_dn: white as u16,
        metadata: file.metadata(&main, &mosaic)?,
        ..RawImage::default()
    })
}

/// Reads a 16-bit grey TIFF file as the numbers of a monochrome sensor: nothing in it says more.
pub fn read_tiff<R: Read + Seek>(from: R) -> Result<RawImage, Invalid> {
    let mut decoder = Decoder::new(from).map_err(unreadable)?;
    let (width, height) = decoder.dimensions().map_err(unreadable)?;
    let DecodingResult::U16(data) = decoder.read_image().map_err(unreadable)? else {
        return Err(Invalid::new("BitsPerSample", "the file does not hold 16-bit numbers"));
    };
    let (width, height) = (width as usize, height as usize);
    if data.len() != width * height {
        return Err(Invalid::new("SamplesPerPixel", "the file holds more than one number a pixel"));
    }
    Ok(RawImage::bare(width, height, data, Cfa::mono(), u16::MAX))
}

fn unreadable(error: TiffError) -> Invalid {
    Invalid::new("", format!("cannot read it as TIFF: {error}"))
}

/// A file whose tags can be asked for.
struct Tags<R: Read + Seek> {
    decoder: Decoder<R>,
}

impl<R: Read + Seek> Tags<R> {
    fn value(&mut self, directory: &Directory, tag: Tag) -> Result<Option<Value>, Invalid> {
        self.decoder.read_directory_tags(directory).find_tag(tag).map_err(unreadable)
    }

    /// All numbers of a tag; none where it is missing.
    fn numbers(&mut self, directory: &Directory, tag: Tag) -> Result<Vec<f64>, Invalid> {
        let Some(value) = self.value(directory, tag)? else { return Ok(Vec::new()) };
        let values = if let Value::List(values) = value { values } else { vec![value] };
        values.into_iter().map(|value| number(tag, value)).collect()
    }

    /// The first number of a tag.
    fn number(&mut self, directory: &Directory, tag: Tag) -> Result<Option<f64>, Invalid> {
        Ok(self.numbers(directory, tag)?.first().copied())
    }

    /// The tag's numbers, if there are exactly so many.
    fn array<const N: usize>(&mut self, directory: &Directory, tag: Tag) -> Result<Option<[f64; N]>, Invalid> {
        Ok(<[f64; N]>::try_from(self.numbers(directory, tag)?).ok())
    }

    /// The directory of the picture of full resolution beneath the main one.
    fn find_mosaic(&mut self, main: &Directory) -> Result<Directory, Invalid> {
        let pointers = match self.value(main, Tag::SubIfd)? {
            Some(value) => value.into_ifd_vec().map_err(unreadable)?,
            None => Vec::new(),
        };
        for pointer in pointers {
            let directory = self.decoder.read_directory(pointer).map_err(unreadable)?;
            let photometric = self.number(&directory, Tag::PhotometricInterpretation)?;
            let is_raw = [COLOR_FILTER_ARRAY, LINEAR_RAW].into_iter().any(|p| photometric == Some(f64::from(p)));
            if is_raw && self.number(&directory, Tag::NewSubfileType)?.unwrap_or(0.0) == 0.0 {
                return Ok(directory);
            }
        }
        Err(Invalid::new("SubIFDs", "the file holds no raw picture").help("give a raw.dng that photosite wrote"))
    }

    fn pixels(&mut self, mosaic: &Directory, count: usize) -> Result<Vec<u16>, Invalid> {
        for (tag, wanted, name) in [
            (Tag::Compression, f64::from(CompressionMethod::None.to_u16()), "Compression"),
            (Tag::BitsPerSample, 16.0, "BitsPerSample"),
            (Tag::SamplesPerPixel, 1.0, "SamplesPerPixel"),
        ] {
            let found = self.number(mosaic, tag)?.unwrap_or(1.0);
            if found != wanted {
                let message = format!("{found} instead of {wanted}");
                return Err(Invalid::new(name, message).help("only uncompressed pictures of 16 bits can be read"));
            }
        }
        let offsets = self.numbers(mosaic, Tag::StripOffsets)?;
        let lengths = self.numbers(mosaic, Tag::StripByteCounts)?;
        let mut bytes = Vec::new();
        for (&offset, &length) in offsets.iter().zip(&lengths) {
            let reader = self.decoder.inner();
            let strip = reader.seek(SeekFrom::Start(offset as u64)).and_then(|_| {
                // Takes memory only for what is there, whatever length a damaged file states.
                reader.take((length as u64).min(2 * count as u64)).read_to_end(&mut bytes)
            });
            strip.map_err(|error| unreadable(error.into()))?;
        }
        if bytes.len() != 2 * count {
            let message = format!("{} bytes of pixels instead of {}", bytes.len(), 2 * count);
            return Err(Invalid::new("StripByteCounts", message).help("the file is cut short or damaged"));
        }
        let from_bytes = match self.decoder.byte_order() {
            ByteOrder::LittleEndian => u16::from_le_bytes,
            ByteOrder::BigEndian => u16::from_be_bytes,
        };
        Ok(bytes.as_chunks::<2>().0.iter().map(|pair| from_bytes(*pair)).collect())
    }

    fn cfa(&mut self, mosaic: &Directory) -> Result<Cfa, Invalid> {
        if self.number(mosaic, Tag::PhotometricInterpretation)? == Some(f64::from(LINEAR_RAW)) {
            return Ok(Cfa::mono());
        }
        let size = self.numbers(mosaic, tag::CFA_REPEAT_PATTERN_DIM)?;
        let colours = self.numbers(mosaic, tag::CFA_PATTERN)?;
        let letter = |&colour: &f64| ["R", "G", "B"].get(colour as usize).copied().unwrap_or("?");
        let pattern: String = colours.iter().map(letter).collect();
        if size != [2.0, 2.0] {
            return Err(Invalid::new("CFARepeatPatternDim", format!("{size:?} instead of 2 rows and 2 columns")));
        }
        Cfa::parse(&pattern).map_err(|error| Invalid::new("CFAPattern", error.message))
    }

    fn metadata(&mut self, main: &Directory, mosaic: &Directory) -> Result<RawMetadata, Invalid> {
        let exif = match self.value(main, Tag::ExifDirectory)? {
            Some(pointer) => {
                let pointer = pointer.into_ifd_pointer().map_err(unreadable)?;
                self.decoder.read_directory(pointer).map_err(unreadable)?
            }
            None => Directory::empty(),
        };
        let camera_model = match self.value(main, Tag::Model)? {
            Some(text) => text.into_string().map_err(unreadable)?,
            None => String::new(),
        };
        let matrix = |entries: [f64; 9]| entries.as_chunks::<3>().0.to_vec();
        Ok(RawMetadata {
            camera_model,
            exposure_time_s: self.number(&exif, tag::EXPOSURE_TIME)?.unwrap_or(0.0),
            f_number: self.number(&exif, tag::F_NUMBER)?,
            focal_length_m: self.number(&exif, tag::FOCAL_LENGTH)?.map(|mm| mm * 1e-3),
            colour_matrix_d65: self.array(main, tag::COLOR_MATRIX_1)?.map(matrix),
            colour_matrix_a: self.array(main, tag::COLOR_MATRIX_2)?.map(matrix),
            as_shot_neutral: self.array::<3>(main, tag::AS_SHOT_NEUTRAL)?.map(|neutral| neutral.to_vec()),
            noise_profile: self.numbers(mosaic, tag::NOISE_PROFILE)?.as_chunks::<2>().0.to_vec(),
            ..RawMetadata::default()
        })
    }
}

fn number(tag: Tag, value: Value) -> Result<f64, Invalid> {
    let signed = value.clone().into_i64().map(|v| v as f64);
    let float = || value.clone().into_f64().or_else(|_| value.clone().into_f32().map(f64::from));
    let unsigned = || value.clone().into_u64().map(|v| v as f64);
    let fraction = || {
        if let Value::Rational(n, d) = value {
            return Some(f64::from(n) / f64::from(d));
        }
        if let Value::SRational(n, d) = value { Some(f64::from(n) / f64::from(d)) } else { None }
    };
    unsigned()
        .or(signed)
        .or_else(|_| float())
        .ok()
        .or_else(fraction)
        .ok_or_else(|| Invalid::new(format!("tag {}", tag.to_u16()), "not a number").help("the file is damaged"))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::raw::{write_dng, write_tiff};

    fn picture(cfa: &str, width: usize, height: usize) -> RawImage {
        let cfa = Cfa::parse(cfa).expect("known");
        let colour = !cfa.is_mono();
        RawImage {
            width,
            height,
            data: (0..width * height).map(|i| (i as u16).wrapping_mul(40_503)).collect(),
            bits: 12,
            black_level_dn: 64.into(),
            white_level_dn: 4095,
            metadata: RawMetadata {
                camera_model: "a camera".to_owned(),
                exposure_time_s: 0.01,
                f_number: Some(2.8),
                focal_length_m: colour.then_some(0.016),
                colour_matrix_d65: colour.then_some(vec![[0.75, -0.25, -0.125], [-0.5, 1.25, 0.25], [0.0, 0.125, 0.5]]),
                colour_matrix_a: colour.then_some(vec![[0.875, -0.25, -0.125], [-0.5, 1.5, 0.25], [0.0, 0.25, 0.5]]),
                as_shot_neutral: colour.then_some(vec![0.5, 1.0, 0.75]),
                noise_profile: vec![[1e-4, 2e-7]; cfa.channels().len()],
                ..RawMetadata::default()
            },
            cfa,
            ..RawImage::default()
        }
    }

    fn dng(raw: &RawImage) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        write_dng(raw, &mut file).expect("written");
        file.into_inner()
    }

    #[test]
    fn dng_files_come_back_as_they_went() {
        for cfa in ["RGGB", "BGGR", "GRBG", "GBRG", "mono"] {
            for (width, height) in [(1, 1), (2, 2), (37, 23), (300, 5)] {
                let raw = picture(cfa, width, height);
                assert_eq!(read_dng(Cursor::new(dng(&raw))), Ok(raw), "{cfa} {width} × {height}");
            }
        }
    }

    #[test]
    fn pictures_without_pixels_are_not_written() {
        for (width, height) in [(0, 0), (0, 4), (4, 0)] {
            let raw = picture("RGGB", width, height);
            assert!(write_dng(&raw, Cursor::new(Vec::new())).is_err());
            assert!(write_tiff(&raw, Cursor::new(Vec::new())).is_err());
        }
    }

    #[test]
    fn tiff_files_come_back_as_they_went() {
        let raw = picture("RGGB", 37, 23);
        let mut file = Cursor::new(Vec::new());
        write_tiff(&raw, &mut file).expect("written");
        file.rewind().expect("in memory");
        let read = read_tiff(file).expect("a TIFF file");
        assert_eq!((read.width, read.height, read.data), (37, 23, raw.data));
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let raw = picture("GBRG", 37, 23);
        assert_eq!(dng(&raw), dng(&raw));
    }

    #[test]
    fn damaged_files_are_errors_and_no_panics() {
        let whole = dng(&picture("RGGB", 20, 10));
        for length in 0..whole.len() {
            assert!(read_dng(Cursor::new(&whole[..length])).is_err(), "cut to {length} bytes");
        }
        let mut file = whole.clone();
        for at in 0..file.len() {
            for value in [0x00, 0xff, file[at] ^ 0x10] {
                file[at] = value;
                let _ = read_dng(Cursor::new(&file));
            }
            file[at] = whole[at];
        }
        assert!(read_dng(Cursor::new(b"not a raw file")).is_err());
        assert!(read_tiff(Cursor::new(b"II*\0\0\0\0\0")).is_err());
        let mut tiff = Cursor::new(Vec::new());
        write_tiff(&picture("mono", 4, 4), &mut tiff).expect("written");
        tiff.rewind().expect("in memory");
        assert!(read_dng(tiff).expect_err("no DNG").message.contains("no raw picture"));
    }
}
