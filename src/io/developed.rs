//! Developed pictures as files, in the format that the file's name says. Every format but PGM and PPM says in an ICC
//! profile, and EXR in its chromaticities, what its colours are; and what shape its pixels have, where they are not
//! square: PNG in pHYs, TIFF in its resolutions, JPEG in its densities, EXR in pixelAspectRatio.
//!
//! | extension | holds |
//! |---|---|
//! | `.png` | 8 or 16 bits |
//! | `.tif`, `.tiff` | 8 or 16 bits, uncompressed; 32-bit floats of what is no picture for viewers |
//! | `.jpg`, `.jpeg` | 8 bits |
//! | `.pgm` | 8 or 16 bits of grey, P5 |
//! | `.ppm` | 8 or 16 bits, P6, or P5 for grey |
//! | `.exr` | linear 32-bit floats |
//! | `.npy` | linear 32-bit floats of the shape (rows, columns) or (rows, columns, components) |
//!
//! Numbers of a colour model such as HSV, and X, Y and Z, are 32-bit floats: in EXR files planes of their names, in TIFF
//! and NPY files in their order. Hues go from 0 to 360, L\* from 0 to 100, a\* and b\* about 0, all else from 0 to 1. TIFF
//! says what they are in ImageDescription, and takes them for no colours (BlackIsZero, with two unspecified samples).

use std::io::{self, Seek, Write};

use image::codecs::jpeg::{JpegEncoder, PixelDensity, PixelDensityUnit};
use image::{ExtendedColorType, ImageEncoder as _, ImageError};
use rayon::prelude::*;
use tiff::encoder::colortype::{ColorType, Gray8, Gray16, Gray32Float, RGB8, RGB16};
use tiff::encoder::{ImageEncoder, Rational, TiffEncoder, TiffKindStandard, TiffValue};
use tiff::tags::{ExtraSamples, ResolutionUnit, Tag};
use tiff::{TiffError, TiffResult};

pub use super::picture_format::PictureFormat;

use super::exr::{Attribute, write_exr};
use super::icc::icc_profile;
use super::npy::write_planes;
use super::output::Sink;
use super::picture_format::Numbers;
use crate::colour::{ColourSpace, Transfer};
use crate::develop::{Codes, DevelopSettings, EncodedPicture, encode, in_model};
use crate::image::Planes;
use crate::units::Seconds;

/// What a file of a developed picture holds.
pub enum PictureNumbers {
    /// Codes for display.
    Codes(EncodedPicture),
    /// Linear light, or the numbers of a colour model, and what EXR files say of them.
    Floats(Planes, Vec<(&'static str, Attribute)>),
}

/// What a file of this format holds of linear planes that were developed by these settings: with tone curve, colour model
/// and encoding. The pixels are `aspect` times as wide as high. Settings and planes must be such that the format can hold
/// them.
pub fn numbers(planes: Planes, settings: &DevelopSettings, aspect: f64, format: PictureFormat) -> PictureNumbers {
    let space = settings.colour_space;
    match format.numbers(settings) {
        Numbers::Codes => {
            let picture = encode(planes, &settings.encoding());
            PictureNumbers::Codes(EncodedPicture { pixel_aspect: aspect, ..picture })
        }
        Numbers::Linear => {
            let attributes = attributes(&planes, space, aspect);
            PictureNumbers::Floats(planes, attributes)
        }
        Numbers::Model => {
            let what = format!("{} of {}", settings.colour_model.name(), space.name());
            let attributes =
                vec![("colorSpace", Attribute::Text(what)), ("pixelAspectRatio", Attribute::PixelAspect(aspect))];
            PictureNumbers::Floats(in_model(planes, settings), attributes)
        }
    }
}

/// Writes [what the format holds](numbers) of a picture.
pub fn write_developed(
    planes: Planes,
    settings: &DevelopSettings,
    aspect: f64,
    format: PictureFormat,
    to: &mut dyn Sink,
) -> io::Result<()> {
    let (planes, attributes) = match numbers(planes, settings, aspect, format) {
        PictureNumbers::Codes(picture) if format == PictureFormat::Jpeg => {
            return write_jpeg(&picture, settings.jpeg_quality, to);
        }
        PictureNumbers::Codes(picture) => return write_encoded(&picture, format, to),
        PictureNumbers::Floats(planes, attributes) => (planes, attributes),
    };
    match format {
        PictureFormat::Exr => write_exr(&planes, &attributes, to),
        PictureFormat::Npy => {
            let data: Vec<&[f32]> = planes.channels().iter().map(|channel| &channel.data[..]).collect();
            write_planes([planes.width(), planes.height()], &data, |value| value, to)
        }
        PictureFormat::Tiff | PictureFormat::Png | PictureFormat::Jpeg | PictureFormat::Pgm | PictureFormat::Ppm => {
            let names: Vec<&str> = planes.channels().iter().map(|channel| &channel.name[..]).collect();
            let (model, space) = (settings.colour_model.name(), settings.colour_space.name());
            write_float_tiff(&planes, &format!("{model}: {} of {space}", names.join(", ")), aspect, to)
        }
    }
}

/// Writes a picture of codes as PNG. The picture must have pixels.
///
/// Its colours are stated twice: by the ICC profile, and by code points (cICP) where there are such, which screens of
/// more than sRGB go by ([Png3](crate::references#png3)).
pub fn write_png<W: Write>(picture: &EncodedPicture, to: W) -> io::Result<()> {
    let [width, height] = sides(picture)?;
    let mut info = png::Info::with_size(width, height);
    info.color_type = if picture.components == 1 { png::ColorType::Grayscale } else { png::ColorType::Rgb };
    info.icc_profile = Some(icc_profile(picture).into());
    info.bit_depth = match picture.codes {
        Codes::U8(_) => png::BitDepth::Eight,
        Codes::U16(_) => png::BitDepth::Sixteen,
    };
    info.pixel_dims = not_square(picture.pixel_aspect).map(|[xppu, yppu]| png::PixelDimensions {
        xppu,
        yppu,
        unit: png::Unit::Unspecified,
    });
    let mut encoder = png::Encoder::with_info(to, info)?;
    // Noise does not compress: more effort gains a few percent and takes several times as long.
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    if let Some([primaries, transfer]) = code_points(picture) {
        // RGB rather than luma and chroma, and all codes used.
        writer.write_chunk(png::chunk::cICP, &[primaries, transfer, 0, 1])?;
    }
    match &picture.codes {
        Codes::U8(codes) => writer.write_image_data(codes)?,
        Codes::U16(codes) => writer.write_image_data(&big_endian(codes))?,
    }
    Ok(writer.finish()?)
}

/// Columns and rows of pixels along equal lengths; `None` of square ones.
fn not_square(aspect: f64) -> Option<[u32; 2]> {
    (aspect != 1.0).then(|| [(1e6 / aspect).round() as u32, 1_000_000])
}

/// Primaries and transfer function as H.273 numbers them; `None` where it has no number for one of them.
fn code_points(picture: &EncodedPicture) -> Option<[u8; 2]> {
    let primaries = match picture.colour_space {
        ColourSpace::Srgb => 1,
        ColourSpace::DisplayP3 => 12,
        ColourSpace::Rec2020 => 9,
        ColourSpace::Acescg | ColourSpace::Xyz => return None,
    };
    let transfer = match picture.transfer {
        Transfer::Srgb => 13,
        Transfer::Linear => 8,
        Transfer::Gamma(2.2) => 4,
        Transfer::Gamma(2.8) => 5,
        Transfer::Gamma(_) => return None,
    };
    Some([primaries, transfer])
}

fn big_endian(codes: &[u16]) -> Vec<u8> {
    let mut bytes = vec![0; 2 * codes.len()];
    bytes.as_chunks_mut().0.par_iter_mut().zip(codes).for_each(|(bytes, code)| *bytes = code.to_be_bytes());
    bytes
}

/// Writes a picture of codes in a format that holds such; JPEG with the quality that settings have by default.
pub fn write_encoded(picture: &EncodedPicture, format: PictureFormat, to: &mut dyn Sink) -> io::Result<()> {
    match format {
        PictureFormat::Png => write_png(picture, to),
        PictureFormat::Tiff => write_tiff(picture, to),
        PictureFormat::Jpeg => write_jpeg(picture, DevelopSettings::default().jpeg_quality, to),
        PictureFormat::Pgm if picture.components != 1 => Err(io::Error::other("a PGM file holds no colours")),
        PictureFormat::Pgm | PictureFormat::Ppm => write_ppm(picture, to),
        PictureFormat::Exr | PictureFormat::Npy => {
            Err(io::Error::other("EXR and NPY files hold linear values, not codes"))
        }
    }
}

/// Writes linear planes as EXR, with the chromaticities of their colour space; the pixels are `aspect` times as wide as
/// high.
pub fn write_linear<W: Write + Seek>(planes: &Planes, space: ColourSpace, aspect: f64, to: W) -> io::Result<()> {
    write_exr(planes, &attributes(planes, space, aspect), to)
}

/// Writes the linear planes of a bracket as EXR, with the exposure time that a value of 1 saturates in the attribute
/// `exposureTime`.
pub fn write_hdr<W: Write + Seek>(
    planes: &Planes,
    space: ColourSpace,
    aspect: f64,
    time: Seconds,
    to: W,
) -> io::Result<()> {
    let mut attributes = attributes(planes, space, aspect);
    attributes.push(("exposureTime", Attribute::Number(time.0)));
    write_exr(planes, &attributes, to)
}

/// What tells readers of the colour space: the name, and for colour the standard attribute; and of the shape of pixels.
fn attributes(planes: &Planes, space: ColourSpace, aspect: f64) -> Vec<(&'static str, Attribute)> {
    let mut attributes = vec![("colorSpace", Attribute::Text(space.name().to_owned()))];
    if planes.channels().len() == 3 {
        attributes.push(("chromaticities", Attribute::Chromaticities(space.chromaticities())));
    }
    attributes.push(("pixelAspectRatio", Attribute::PixelAspect(aspect)));
    attributes
}

fn write_jpeg(picture: &EncodedPicture, quality: u8, to: &mut dyn Sink) -> io::Result<()> {
    let Codes::U8(codes) = &picture.codes else { return Err(io::Error::other("a JPEG file has 8 bits")) };
    let mut encoder = JpegEncoder::new_with_quality(to, quality);
    if let Some([x, y]) = not_square(picture.pixel_aspect) {
        // As near as 16 bits come.
        let density = [x, y].map(|n| (f64::from(n) * (65_535.0 / f64::from(x.max(y)))).round() as u16);
        encoder.set_pixel_density(PixelDensity {
            density: (density[0], density[1]),
            unit: PixelDensityUnit::PixelAspectRatio,
        });
    }
    encoder.set_icc_profile(icc_profile(picture)).map_err(io::Error::other)?;
    let [width, height] = sides(picture)?;
    let colour = if picture.components == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
    encoder.write_image(codes, width, height, colour).map_err(|error| {
        let ImageError::IoError(error) = error else { return io::Error::other(error) };
        error
    })
}

fn write_tiff(picture: &EncodedPicture, to: &mut dyn Sink) -> io::Result<()> {
    let [width, height] = sides(picture)?;
    let mut file = TiffEncoder::new(to).map_err(tiff_error)?;
    match (&picture.codes, picture.components) {
        (Codes::U8(codes), 1) => write_tiff_picture::<_, Gray8>(file.new_image(width, height), picture, codes),
        (Codes::U8(codes), _) => write_tiff_picture::<_, RGB8>(file.new_image(width, height), picture, codes),
        (Codes::U16(codes), 1) => write_tiff_picture::<_, Gray16>(file.new_image(width, height), picture, codes),
        (Codes::U16(codes), _) => write_tiff_picture::<_, RGB16>(file.new_image(width, height), picture, codes),
    }
    .map_err(tiff_error)
}

fn write_tiff_picture<W: Write + Seek, C: ColorType>(
    image: TiffResult<ImageEncoder<'_, W, C, TiffKindStandard>>,
    picture: &EncodedPicture,
    codes: &[C::Inner],
) -> TiffResult<()>
where
    [C::Inner]: TiffValue,
{
    let mut image = image?;
    state_aspect(&mut image, picture.pixel_aspect);
    image.encoder().write_tag(Tag::IccProfile, &icc_profile(picture)[..])?;
    image.write_data(codes)
}

fn state_aspect<W: Write + Seek, C: ColorType>(image: &mut ImageEncoder<'_, W, C, TiffKindStandard>, aspect: f64) {
    if let Some([x, y]) = not_square(aspect) {
        image.resolution_unit(ResolutionUnit::None);
        image.x_resolution(Rational { n: x, d: 1_000_000 });
        image.y_resolution(Rational { n: y, d: 1_000_000 });
    }
}

/// Writes planes of floats pixel by pixel.
pub(super) fn write_float_tiff(planes: &Planes, description: &str, aspect: f64, to: &mut dyn Sink) -> io::Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let (width, height) = (side(planes.width())?, side(planes.height())?);
    let mut file = TiffEncoder::new(to).map_err(tiff_error)?;
    let channels = planes.channels();
    let pixels = planes.width() * planes.height();
    let numbers: Vec<f32> = (0..pixels).flat_map(|i| channels.iter().map(move |c| c.data[i])).collect();
    let written = file.new_image::<Gray32Float>(width, height).and_then(|mut image| {
        if channels.len() > 1 {
            image.extra_samples(&vec![ExtraSamples::Unspecified; channels.len() - 1])?;
        }
        state_aspect(&mut image, aspect);
        image.encoder().write_tag(Tag::ImageDescription, description)?;
        image.write_data(&numbers)
    });
    written.map_err(tiff_error)
}

pub(super) fn tiff_error(error: TiffError) -> io::Error {
    let TiffError::IoError(error) = error else { return io::Error::other(error) };
    error
}

fn sides(picture: &EncodedPicture) -> io::Result<[u32; 2]> {
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    Ok([side(picture.width)?, side(picture.height)?])
}

fn write_ppm<W: Write>(picture: &EncodedPicture, mut to: W) -> io::Result<()> {
    let kind = if picture.components == 1 { "P5" } else { "P6" };
    let EncodedPicture { width, height, .. } = picture;
    match &picture.codes {
        Codes::U8(codes) => {
            write!(to, "{kind}\n{width} {height}\n255\n")?;
            to.write_all(codes)
        }
        Codes::U16(codes) => {
            write!(to, "{kind}\n{width} {height}\n65535\n")?;
            // The most significant byte comes first.
            to.write_all(&big_endian(codes))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn picture(components: usize, bits: u8) -> EncodedPicture {
        let n = 5 * 4 * components;
        let codes = if bits == 8 {
            Codes::U8((0..n).map(|i| (i * 13) as u8).collect())
        } else {
            Codes::U16((0..n).map(|i| (i * 4099) as u16).collect())
        };
        let (colour_space, transfer) = (ColourSpace::DisplayP3, Transfer::Srgb);
        EncodedPicture { width: 5, height: 4, components, codes, colour_space, transfer, pixel_aspect: 1.0 }
    }

    #[test]
    fn pictures_come_back_as_they_went() {
        for format in [PictureFormat::Png, PictureFormat::Tiff, PictureFormat::Ppm] {
            for components in [1, 3] {
                for bits in [8, 16] {
                    let picture = picture(components, bits);
                    let mut file = Cursor::new(Vec::new());
                    write_encoded(&picture, format, &mut file).expect("written");
                    let read = image::load_from_memory(file.get_ref()).expect("a picture");
                    assert_eq!((read.width(), read.height()), (5, 4));
                    let codes = match &picture.codes {
                        Codes::U8(codes) => codes.clone(),
                        Codes::U16(codes) => codes.iter().flat_map(|code| code.to_ne_bytes()).collect(),
                    };
                    assert_eq!(read.as_bytes(), codes, "{format:?} {components} × {bits}");
                    let mut again = Cursor::new(Vec::new());
                    write_encoded(&picture, format, &mut again).expect("written");
                    assert_eq!(file, again, "the same bytes");
                }
            }
        }
        let mut grey = Cursor::new(Vec::new());
        write_encoded(&picture(1, 16), PictureFormat::Pgm, &mut grey).expect("written");
        assert!(grey.get_ref().starts_with(b"P5\n5 4\n65535\n"));
        assert!(write_encoded(&picture(3, 8), PictureFormat::Pgm, &mut grey).is_err());
        let refused = PictureFormat::Pgm.check_picture(&Planes::zeros(5, 4, ["R", "G", "B"]));
        assert!(refused.expect_err("colours").message.ends_with("the picture has R, G, B"));
        assert_eq!(PictureFormat::Pgm.check_picture(&Planes::zeros(5, 4, ["Y"])), Ok(()));
        let mut jpeg = Cursor::new(Vec::new());
        write_encoded(&picture(3, 8), PictureFormat::Jpeg, &mut jpeg).expect("written");
        assert_eq!(image::load_from_memory(jpeg.get_ref()).expect("a picture").width(), 5);
    }

    #[test]
    fn png_says_its_colours_by_profile_and_by_numbers() {
        for (colour_space, transfer, expected) in [
            (ColourSpace::Srgb, Transfer::Srgb, Some([1, 13])),
            (ColourSpace::DisplayP3, Transfer::Srgb, Some([12, 13])),
            (ColourSpace::Rec2020, Transfer::Linear, Some([9, 8])),
            (ColourSpace::Srgb, Transfer::Gamma(2.2), Some([1, 4])),
            (ColourSpace::Srgb, Transfer::Gamma(1.8), None),
            (ColourSpace::Acescg, Transfer::Linear, None),
        ] {
            let picture = EncodedPicture { colour_space, transfer, ..picture(3, 16) };
            let mut file = Vec::new();
            write_png(&picture, &mut file).expect("written");
            let reader = png::Decoder::new(Cursor::new(file)).read_info().expect("a picture");
            assert!(reader.info().icc_profile.is_some());
            let found = reader.info().coding_independent_code_points;
            let numbers = found.map(|c| [c.color_primaries, c.transfer_function]);
            assert_eq!(numbers, expected, "{colour_space:?} {transfer:?}");
            assert!(found.is_none_or(|c| c.matrix_coefficients == 0 && c.is_video_full_range_image));
        }
    }
}
