//! Developed images as files, in the format of the file name's extension. Every format but PGM and PPM states its
//! colours, EXR by chromaticities and the others by an ICC profile, and the aspect ratio of pixels that are not square:
//! PNG in pHYs, TIFF in its resolutions, JPEG in its densities, EXR in pixelAspectRatio.
//!
//! | extension | holds |
//! |---|---|
//! | `.png` | 8 or 16 bits |
//! | `.tif`, `.tiff` | 8 or 16 bits, uncompressed; 32-bit floats of what is no image for viewers |
//! | `.jpg`, `.jpeg` | 8 bits |
//! | `.pgm` | 8 or 16 bits of grey, P5 |
//! | `.ppm` | 8 or 16 bits, P6, or P5 for grey |
//! | `.exr` | linear 32-bit floats |
//! | `.npy` | linear 32-bit floats of the shape (rows, columns) or (rows, columns, components) |
//!
//! Values of a colour model such as HSV, and X, Y and Z, are 32-bit floats: in EXR files planes of their names, in TIFF
//! and NPY files in their order. Hues go from 0 to 360, L\* from 0 to 100, a\* and b\* about 0, all else from 0 to 1.
//! TIFF files name them in ImageDescription, and do not declare them as colours (BlackIsZero, with two unspecified
//! samples).

use std::borrow::Cow;
use std::io::{self, Seek, Write};
use std::path::Path;

use super::exr::{Attribute, write_exr};
use super::formats::{FileImage, Format, lists::written, png};
use super::stated_colours::StatedColours;
use photosite_core::colour::ColourSpace;
use photosite_core::image::Planes;
use photosite_core::output::Sink;
use photosite_core::units::Seconds;
use photosite_core::{Invalid, Result};
use photosite_develop::{ColourModel, DevelopSettings, EncodedImage, encode, in_model};

/// Kinds of pixel values in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PixelEncoding {
    /// Codes of an image for display.
    Codes,
    /// Linear components of the colour space.
    Linear,
    /// Values of a colour model.
    Model,
}

/// Formats of developed images, with the settings that they exclude.
impl Format {
    /// Format of a developed image of that name.
    pub fn of_developed(path: &Path) -> Result<&'static Self> {
        written(path, |_| true, "an image that photosite can write")
    }

    /// Kind of pixel values in a file of an image that is developed by these settings.
    fn numbers(&self, settings: &DevelopSettings) -> PixelEncoding {
        let is_light = matches!(settings.colour_model, ColourModel::Rgb | ColourModel::Grey);
        let has_codes = is_light && (settings.colour_model.is_grey() || settings.colour_space != ColourSpace::Xyz);
        match self.is_shown && (has_codes || !self.floats) {
            true => PixelEncoding::Codes,
            false if is_light => PixelEncoding::Linear,
            false => PixelEncoding::Model,
        }
    }

    /// Refuses settings that the format cannot hold.
    pub fn check(&self, settings: &DevelopSettings) -> Result<(), Invalid> {
        let numbers = self.numbers(settings);
        if numbers == PixelEncoding::Codes && !self.bits.contains(&settings.bits) {
            let bits: Vec<String> = self.bits.iter().map(u8::to_string).collect();
            let message = format!("a {} file has {} bits", self.name, bits.join(" or "));
            return Err(Invalid::new("bits", message).help("write a .png or .tiff file"));
        }
        if numbers == PixelEncoding::Codes && !settings.colour_model.is_shown() {
            let name = settings.colour_model.name();
            let message = format!("viewers of such a file would take the pixel values of {name} for colours");
            return Err(Invalid::new("colour_model", message).help("write an .exr, .tiff or .npy file"));
        }
        if numbers == PixelEncoding::Codes
            && settings.colour_space == ColourSpace::Xyz
            && !settings.colour_model.is_grey()
        {
            let message = "X and Z of white pass 1, which codes cannot hold";
            return Err(Invalid::new("colour_space", message)
                .help("write an .exr, .tiff or .npy file, or choose another colour space"));
        }
        if numbers != PixelEncoding::Codes && settings.sharpening != 0.0 {
            let message = "sharpening works on the codes that are shown, not on the floats of this file";
            return Err(
                Invalid::new("sharpening", message).help("write a .png or .tiff file of colour_model = \"rgb\"")
            );
        }
        Ok(())
    }

    /// Keys of the settings that were given and change nothing in such a file.
    pub fn unused_keys(&self, settings: &DevelopSettings) -> Vec<&'static str> {
        let default = DevelopSettings::default();
        let has_codes = self.numbers(settings) == PixelEncoding::Codes;
        let unused = [
            ("jpeg_quality", settings.jpeg_quality != default.jpeg_quality && !self.is_lossy),
            ("bits", settings.bits != default.bits && !has_codes),
            ("dither", settings.dither != default.dither && !has_codes),
        ];
        unused.into_iter().filter_map(|(key, is_unused)| is_unused.then_some(key)).collect()
    }

    /// Refuses an image that the format cannot hold.
    pub fn check_image(&self, planes: &Planes) -> Result<(), Invalid> {
        if !self.holds_channels(planes.channels().len()) {
            let names: Vec<&str> = planes.channels().iter().map(|c| &c.name[..]).collect();
            let message = format!("a {} file holds grey, the image has {}", self.name, names.join(", "));
            return Err(Invalid::new("", message).help("write a .ppm, .png or .tiff file"));
        }
        Ok(())
    }
}

/// Pixel values of a developed image's file.
pub enum DevelopedValues {
    /// Codes for display.
    Codes(EncodedImage),
    /// Linear light, or values of a colour model, and the attributes of EXR files.
    Floats(Planes, Vec<(&'static str, Attribute)>),
}

/// Pixel values in this format of linear planes that were developed by these settings: with tone curve, colour model
/// and encoding. The pixels are `aspect` times as wide as high. Settings and planes must be such that the format can
/// hold them.
pub fn numbers(planes: Planes, settings: &DevelopSettings, aspect: f64, format: &Format) -> DevelopedValues {
    let space = settings.colour_space;
    match format.numbers(settings) {
        PixelEncoding::Codes => {
            let image = encode(planes, &settings.encoding());
            DevelopedValues::Codes(EncodedImage { pixel_aspect: aspect, ..image })
        }
        PixelEncoding::Linear => {
            let attributes = attributes(&planes, space, aspect);
            DevelopedValues::Floats(planes, attributes)
        }
        PixelEncoding::Model => {
            let what = format!("{} of {}", settings.colour_model.name(), space.name());
            let attributes =
                vec![("colorSpace", Attribute::Text(what)), ("pixelAspectRatio", Attribute::PixelAspect(aspect))];
            DevelopedValues::Floats(in_model(planes, settings), attributes)
        }
    }
}

/// Writes the [pixel values](numbers) of a developed image.
pub fn write_developed(
    planes: Planes,
    settings: &DevelopSettings,
    aspect: f64,
    format: &Format,
    to: &mut dyn Sink,
) -> io::Result<()> {
    let (model, space) = (settings.colour_model.name(), settings.colour_space.name());
    let numbers = numbers(planes, settings, aspect, format);
    let image = match &numbers {
        DevelopedValues::Codes(image) => {
            FileImage { jpeg_quality: settings.jpeg_quality, ..FileImage::of_codes(image) }
        }
        DevelopedValues::Floats(planes, attributes) => {
            let names: Vec<&str> = planes.channels().iter().map(|channel| &channel.name[..]).collect();
            FileImage {
                pixel_aspect: aspect,
                description: Some(format!("{model}: {} of {space}", names.join(", "))),
                colours: Cow::Owned(StatedColours::of_exr(attributes.clone())),
                ..FileImage::of_planes(planes)
            }
        }
    };
    format.write(&image, to)
}

/// Writes an image of codes as PNG. The image must have pixels.
pub fn write_png<W: Write>(image: &EncodedImage, to: W) -> io::Result<()> {
    png::write(&FileImage::of_codes(image), to)
}

/// Writes an image of codes in a format that holds such; JPEG with the default quality.
pub fn write_encoded(image: &EncodedImage, format: &Format, to: &mut dyn Sink) -> io::Result<()> {
    format.write(&FileImage::of_codes(image), to)
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

/// Attributes of EXR files: the name of the colour space, its chromaticities for colour, and the pixel aspect ratio.
fn attributes(planes: &Planes, space: ColourSpace, aspect: f64) -> Vec<(&'static str, Attribute)> {
    let mut attributes = vec![("colorSpace", Attribute::Text(space.name().to_owned()))];
    if planes.channels().len() == 3 {
        attributes.push(("chromaticities", Attribute::Chromaticities(space.chromaticities())));
    }
    attributes.push(("pixelAspectRatio", Attribute::PixelAspect(aspect)));
    attributes
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::formats::{EXR, JPEG, NPY, PGM, PNG, PPM, TIFF};
    use photosite_core::colour::Transfer;
    use photosite_develop::Codes;

    fn image(components: usize, bits: u8) -> EncodedImage {
        let n = 5 * 4 * components;
        let codes = if bits == 8 {
            Codes::U8((0..n).map(|i| (i * 13) as u8).collect())
        } else {
            Codes::U16((0..n).map(|i| (i * 4099) as u16).collect())
        };
        let (colour_space, transfer) = (ColourSpace::DisplayP3, Transfer::Srgb);
        EncodedImage { width: 5, height: 4, components, codes, colour_space, transfer, pixel_aspect: 1.0 }
    }

    #[test]
    fn images_come_back_as_they_went() {
        for format in [PNG, TIFF, PPM] {
            for components in [1, 3] {
                for bits in [8, 16] {
                    let image = image(components, bits);
                    let mut file = Cursor::new(Vec::new());
                    write_encoded(&image, &format, &mut file).expect("written");
                    let read = image::load_from_memory(file.get_ref()).expect("an image");
                    assert_eq!((read.width(), read.height()), (5, 4));
                    let codes = match &image.codes {
                        Codes::U8(codes) => codes.clone(),
                        Codes::U16(codes) => codes.iter().flat_map(|code| code.to_ne_bytes()).collect(),
                    };
                    assert_eq!(read.as_bytes(), codes, "{format:?} {components} × {bits}");
                    let mut again = Cursor::new(Vec::new());
                    write_encoded(&image, &format, &mut again).expect("written");
                    assert_eq!(file, again, "the same bytes");
                }
            }
        }
        let mut grey = Cursor::new(Vec::new());
        write_encoded(&image(1, 16), &PGM, &mut grey).expect("written");
        assert!(grey.get_ref().starts_with(b"P5\n5 4\n65535\n"));
        assert!(write_encoded(&image(3, 8), &PGM, &mut grey).is_err());
        let refused = PGM.check_image(&Planes::zeros(5, 4, ["R", "G", "B"]));
        assert!(refused.expect_err("colours").message.ends_with("the image has R, G, B"));
        assert_eq!(PGM.check_image(&Planes::zeros(5, 4, ["Y"])), Ok(()));
        let mut jpeg = Cursor::new(Vec::new());
        write_encoded(&image(3, 8), &JPEG, &mut jpeg).expect("written");
        assert_eq!(image::load_from_memory(jpeg.get_ref()).expect("an image").width(), 5);
    }

    #[test]
    fn settings_that_a_format_cannot_hold_are_refused() {
        let deep = DevelopSettings { bits: 16, ..DevelopSettings::default() };
        assert_eq!(JPEG.check(&deep).expect_err("8 bits").key, "bits");
        let xyz = DevelopSettings { colour_space: ColourSpace::Xyz, ..DevelopSettings::default() };
        assert_eq!(PNG.check(&xyz).expect_err("passes 1").key, "colour_space");
        assert!([EXR, TIFF, NPY].iter().all(|f| f.check(&xyz).is_ok()));
        let lab = DevelopSettings { colour_model: ColourModel::Lab, ..DevelopSettings::default() };
        assert_eq!(JPEG.check(&lab).expect_err("no colours").key, "colour_model");
        let sharp = DevelopSettings { sharpening: 1.0, ..lab.clone() };
        assert_eq!(TIFF.check(&sharp).expect_err("floats").key, "sharpening");
        let coarse = DevelopSettings { jpeg_quality: 50, bits: 16, ..lab };
        assert_eq!(TIFF.unused_keys(&coarse), ["jpeg_quality", "bits"]);
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
            let image = EncodedImage { colour_space, transfer, ..image(3, 16) };
            let mut file = Vec::new();
            write_png(&image, &mut file).expect("written");
            let reader = ::png::Decoder::new(Cursor::new(file)).read_info().expect("an image");
            assert!(reader.info().icc_profile.is_some());
            let found = reader.info().coding_independent_code_points;
            let numbers = found.map(|c| [c.color_primaries, c.transfer_function]);
            assert_eq!(numbers, expected, "{colour_space:?} {transfer:?}");
            assert!(found.is_none_or(|c| c.matrix_coefficients == 0 && c.is_video_full_range_image));
        }
    }
}
