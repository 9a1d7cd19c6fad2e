//! DNG files: the mosaic with everything that a raw developer wants to know, after the Digital Negative specification
//! ([Dng16](crate::references#dng16)), which the names of the tags come from.
//!
//! In: a [`RawImage`]. Out: a file of three directories, as the specification recommends: a thumbnail that any TIFF
//! reader shows, which also carries what holds for the whole picture; beneath it the mosaic, 16 bits a pixel and
//! uncompressed; and EXIF. No date is written, so that the same picture gives the same bytes.

use std::io::{self, Seek, Write};

use tiff::encoder::{DirectoryEncoder, Rational, SRational, TiffEncoder, TiffKindStandard};
use tiff::tags::{Tag, Type};
use tiff::{Directory, TiffResult};

use super::rational::{rational, srational};
use super::tiff::io_error;
use super::{RawImage, thumbnail};

/// Tags that the TIFF library has no name for.
pub(super) mod tag {
    use tiff::tags::Tag;

    pub(crate) const CFA_REPEAT_PATTERN_DIM: Tag = Tag::Unknown(33421);
    pub(crate) const CFA_PATTERN: Tag = Tag::Unknown(33422);
    pub(crate) const EXPOSURE_TIME: Tag = Tag::Unknown(33434);
    pub(crate) const F_NUMBER: Tag = Tag::Unknown(33437);
    pub(crate) const EXIF_VERSION: Tag = Tag::ExifVersion;
    pub(crate) const FOCAL_LENGTH: Tag = Tag::Unknown(37386);
    pub(crate) const DNG_VERSION: Tag = Tag::Unknown(50706);
    pub(crate) const DNG_BACKWARD_VERSION: Tag = Tag::Unknown(50707);
    pub(crate) const UNIQUE_CAMERA_MODEL: Tag = Tag::Unknown(50708);
    pub(crate) const CFA_PLANE_COLOR: Tag = Tag::Unknown(50710);
    pub(crate) const CFA_LAYOUT: Tag = Tag::Unknown(50711);
    pub(crate) const BLACK_LEVEL_REPEAT_DIM: Tag = Tag::Unknown(50713);
    pub(crate) const BLACK_LEVEL: Tag = Tag::Unknown(50714);
    pub(crate) const WHITE_LEVEL: Tag = Tag::Unknown(50717);
    pub(crate) const DEFAULT_SCALE: Tag = Tag::Unknown(50718);
    pub(crate) const DEFAULT_CROP_ORIGIN: Tag = Tag::Unknown(50719);
    pub(crate) const DEFAULT_CROP_SIZE: Tag = Tag::Unknown(50720);
    pub(crate) const COLOR_MATRIX_1: Tag = Tag::Unknown(50721);
    pub(crate) const COLOR_MATRIX_2: Tag = Tag::Unknown(50722);
    pub(crate) const AS_SHOT_NEUTRAL: Tag = Tag::Unknown(50728);
    pub(crate) const BASELINE_EXPOSURE: Tag = Tag::Unknown(50730);
    pub(crate) const CALIBRATION_ILLUMINANT_1: Tag = Tag::Unknown(50778);
    pub(crate) const CALIBRATION_ILLUMINANT_2: Tag = Tag::Unknown(50779);
    pub(crate) const ACTIVE_AREA: Tag = Tag::Unknown(50829);
    pub(crate) const NOISE_PROFILE: Tag = Tag::Unknown(51041);
}

/// PhotometricInterpretation of a mosaic.
pub(super) const COLOR_FILTER_ARRAY: u16 = 32803;
/// PhotometricInterpretation of pixels that all see the same.
pub(super) const LINEAR_RAW: u16 = 34892;
/// EXIF's number for D65 as a light source.
const D65: u16 = 21;
/// EXIF's number for CIE illuminant A.
const STANDARD_LIGHT_A: u16 = 17;
/// NewSubfileType of a picture of reduced resolution; 0 is the picture itself.
const REDUCED: u32 = 1;

type Ifd<'a, W> = DirectoryEncoder<'a, W, TiffKindStandard>;

/// Writes a DNG file. The picture must have pixels, and fewer than a TIFF file can hold (4 GiB).
pub fn write_dng<W: Write + Seek>(raw: &RawImage, to: W) -> io::Result<()> {
    if raw.data.is_empty() {
        return Err(io::Error::other("the picture has no pixels"));
    }
    if !(raw.cfa.is_bayer() || raw.cfa.is_mono())
        || raw.active_area.is_some()
        || raw.black_level_dn.as_uniform().is_none()
    {
        return Err(io::Error::other(format!("DNG files cannot hold pictures of the layout {}", raw.cfa)));
    }
    write_directories(raw, to).map_err(io_error)
}

fn write_directories<W: Write + Seek>(raw: &RawImage, to: W) -> TiffResult<()> {
    let mut file = TiffEncoder::new(to)?;
    let mut mosaic = file.extra_directory()?;
    write_mosaic(raw, &mut mosaic)?;
    let mosaic = mosaic.finish_with_offsets()?;
    let mut exif = file.extra_directory()?;
    write_exif(raw, &mut exif)?;
    let exif = exif.finish_with_offsets()?;
    let mut main = file.image_directory()?;
    main.write_tag(Tag::SubIfd, mosaic.offset)?;
    main.write_tag(Tag::ExifDirectory, exif.offset)?;
    write_main(raw, &mut main)?;
    main.finish()
}

/// The thumbnail, and what holds for the file as a whole.
fn write_main<W: Write + Seek>(raw: &RawImage, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let metadata = &raw.metadata;
    let thumbnail = thumbnail::thumbnail(raw);
    let rgb = tiff::tags::PhotometricInterpretation::RGB.to_u16();
    write_picture(ifd, [thumbnail.width, thumbnail.height], 8, 3, rgb, &thumbnail.rgb[..])?;
    ifd.write_tag(Tag::NewSubfileType, REDUCED)?;
    ifd.write_tag(Tag::XResolution, Rational { n: 72, d: 1 })?;
    ifd.write_tag(Tag::YResolution, Rational { n: 72, d: 1 })?;
    ifd.write_tag(Tag::ResolutionUnit, tiff::tags::ResolutionUnit::Inch.to_u16())?;
    write_text(ifd, Tag::Make, "photosite")?;
    write_text(ifd, Tag::Model, &metadata.camera_model)?;
    write_text(ifd, Tag::Software, concat!("photosite ", env!("CARGO_PKG_VERSION")))?;
    ifd.write_tag(Tag::Orientation, 1u16)?;
    ifd.write_tag(tag::DNG_VERSION, &[1u8, 4, 0, 0][..])?;
    ifd.write_tag(tag::DNG_BACKWARD_VERSION, &[1u8, 1, 0, 0][..])?;
    write_text(ifd, tag::UNIQUE_CAMERA_MODEL, &format!("photosite {}", metadata.camera_model))?;
    ifd.write_tag(tag::BASELINE_EXPOSURE, SRational { n: 0, d: 1 })?;
    // D65 comes first because many developers use the first matrix only.
    for (matrix, matrix_tag, light_tag, light) in [
        (&metadata.colour_matrix_d65, tag::COLOR_MATRIX_1, tag::CALIBRATION_ILLUMINANT_1, D65),
        (&metadata.colour_matrix_a, tag::COLOR_MATRIX_2, tag::CALIBRATION_ILLUMINANT_2, STANDARD_LIGHT_A),
    ] {
        if let Some(matrix) = matrix {
            let entries: Vec<SRational> = matrix.as_flattened().iter().map(|&entry| srational(entry)).collect();
            ifd.write_tag(matrix_tag, &entries[..])?;
            ifd.write_tag(light_tag, light)?;
        }
    }
    if let Some(neutral) = &metadata.as_shot_neutral {
        ifd.write_tag(tag::AS_SHOT_NEUTRAL, &neutral.iter().copied().map(rational).collect::<Vec<_>>()[..])?;
    }
    Ok(())
}

/// The digital numbers.
fn write_mosaic<W: Write + Seek>(raw: &RawImage, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let photometric = if raw.cfa.is_mono() { LINEAR_RAW } else { COLOR_FILTER_ARRAY };
    write_picture(ifd, [raw.width, raw.height], 16, 1, photometric, &raw.data[..])?;
    let (width, height) = (u32::try_from(raw.width)?, u32::try_from(raw.height)?);
    ifd.write_tag(Tag::NewSubfileType, 0u32)?;
    if !raw.cfa.is_mono() {
        let (columns, rows) = raw.cfa.tile_size();
        let pattern: Vec<u8> =
            (0..columns * rows).map(|i| raw.cfa.channel_at(i % columns, i / columns) as u8).collect();
        ifd.write_tag(tag::CFA_REPEAT_PATTERN_DIM, &[u16::try_from(rows)?, u16::try_from(columns)?][..])?;
        ifd.write_tag(tag::CFA_PATTERN, &pattern[..])?;
        ifd.write_tag(tag::CFA_PLANE_COLOR, &[0u8, 1, 2][..])?;
        ifd.write_tag(tag::CFA_LAYOUT, 1u16)?;
    }
    ifd.write_tag(tag::BLACK_LEVEL_REPEAT_DIM, &[1u16, 1][..])?;
    ifd.write_tag(tag::BLACK_LEVEL, raw.black_level_dn.mean() as u16)?;
    ifd.write_tag(tag::WHITE_LEVEL, u32::from(raw.white_level_dn))?;
    ifd.write_tag(tag::DEFAULT_SCALE, &[Rational { n: 1, d: 1 }, Rational { n: 1, d: 1 }][..])?;
    ifd.write_tag(tag::DEFAULT_CROP_ORIGIN, &[0u32, 0][..])?;
    ifd.write_tag(tag::DEFAULT_CROP_SIZE, &[width, height][..])?;
    ifd.write_tag(tag::ACTIVE_AREA, &[0, 0, height, width][..])?;
    if !raw.metadata.noise_profile.is_empty() {
        ifd.write_tag(tag::NOISE_PROFILE, raw.metadata.noise_profile.as_flattened())?;
    }
    Ok(())
}

fn write_exif<W: Write + Seek>(raw: &RawImage, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let version = ifd.write_entry_bytes(Type::UNDEFINED, b"0232")?;
    let mut undefined = Directory::empty();
    undefined.extend([(tag::EXIF_VERSION, version)]);
    ifd.extend_from(&undefined);
    ifd.write_tag(tag::EXPOSURE_TIME, rational(raw.metadata.exposure_time_s))?;
    if let Some(f_number) = raw.metadata.f_number {
        ifd.write_tag(tag::F_NUMBER, rational(f_number))?;
    }
    if let Some(focal_length_m) = raw.metadata.focal_length_m {
        ifd.write_tag(tag::FOCAL_LENGTH, rational(focal_length_m * 1e3))?;
    }
    Ok(())
}

/// The pixels in one strip, and the tags that TIFF wants with them.
fn write_picture<W: Write + Seek, T: ?Sized>(
    ifd: &mut Ifd<'_, W>,
    [width, height]: [usize; 2],
    bits: u16,
    samples: u16,
    photometric: u16,
    pixels: &T,
) -> TiffResult<()>
where
    for<'t> &'t T: tiff::encoder::TiffValue,
{
    let offset = ifd.write_data(pixels)?;
    let bytes = width * height * usize::from(samples) * usize::from(bits / 8);
    pad(ifd, bytes)?;
    let (width, height) = (u32::try_from(width)?, u32::try_from(height)?);
    ifd.write_tag(Tag::ImageWidth, width)?;
    ifd.write_tag(Tag::ImageLength, height)?;
    ifd.write_tag(Tag::BitsPerSample, &vec![bits; usize::from(samples)][..])?;
    ifd.write_tag(Tag::Compression, tiff::tags::CompressionMethod::None.to_u16())?;
    ifd.write_tag(Tag::PhotometricInterpretation, photometric)?;
    ifd.write_tag(Tag::StripOffsets, u32::try_from(offset)?)?;
    ifd.write_tag(Tag::StripByteCounts, u32::try_from(bytes)?)?;
    ifd.write_tag(Tag::RowsPerStrip, height)?;
    ifd.write_tag(Tag::SamplesPerPixel, samples)?;
    ifd.write_tag(Tag::PlanarConfiguration, tiff::tags::PlanarConfiguration::Chunky.to_u16())
}

/// Text, which in TIFF is ASCII without zeros, followed by one.
fn write_text<W: Write + Seek>(ifd: &mut Ifd<'_, W>, tag: Tag, text: &str) -> TiffResult<()> {
    let ascii: String = text.chars().map(|c| if c.is_ascii() && !c.is_ascii_control() { c } else { '?' }).collect();
    let bytes = ascii.len() + 1;
    ifd.write_tag(tag, ascii.as_str())?;
    // Text of up to 4 bytes lies in the directory itself.
    if bytes > 4 { pad(ifd, bytes) } else { Ok(()) }
}

/// What comes next must begin at an even offset (TIFF 6.0, p. 15).
fn pad<W: Write + Seek>(ifd: &mut Ifd<'_, W>, bytes_written: usize) -> TiffResult<()> {
    if bytes_written % 2 == 1 {
        ifd.write_data(0u8)?;
    }
    Ok(())
}
