//! Developed pictures as files, in the format that the file's name says. Every format but PPM says in an ICC profile, and
//! EXR in its chromaticities, what its colours are.
//!
//! | extension | holds |
//! |---|---|
//! | `.png` | 8 or 16 bits |
//! | `.tif`, `.tiff` | 8 or 16 bits, uncompressed |
//! | `.jpg`, `.jpeg` | 8 bits, quality 95 |
//! | `.ppm` | 8 or 16 bits, P6, or P5 for grey |
//! | `.exr` | linear 32-bit floats |

use std::io::{self, Seek, Write};
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::codecs::tiff::TiffEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

use super::exr::{Attribute, write_exr};
use super::icc::icc_profile;
use super::output::Sink;
use crate::colour::ColourSpace;
use crate::develop::{Codes, DevelopSettings, EncodedPicture};
use crate::image::Planes;
use crate::{Error, Invalid, Result};

/// Formats of developed pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// Portable network graphics.
    Png,
    /// Tagged image file format.
    Tiff,
    /// JPEG.
    Jpeg,
    /// Portable pixmap, or greymap.
    Ppm,
    /// OpenEXR.
    Exr,
}

impl PictureFormat {
    /// The format that a file's name says.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "png" => Ok(Self::Png),
            "tif" | "tiff" => Ok(Self::Tiff),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            "ppm" => Ok(Self::Ppm),
            "exr" => Ok(Self::Exr),
            _ => Err(Error::Usage {
                message: format!("{} is no name of a picture that photosite can write", path.display()),
                help: Some("give a name that ends with .png, .tiff, .jpg, .ppm or .exr".to_owned()),
            }),
        }
    }

    /// Refuses settings that the format cannot hold.
    pub fn check(self, settings: &DevelopSettings) -> Result<(), Invalid> {
        if self == Self::Jpeg && settings.bits != 8 {
            return Err(Invalid::new("bits", "a JPEG file has 8 bits").help("write a .png or .tiff file"));
        }
        if self != Self::Exr && settings.colour_space == ColourSpace::Xyz {
            let message = "X and Z of white pass 1, which codes cannot hold";
            return Err(
                Invalid::new("colour_space", message).help("write an .exr file, or choose another colour space")
            );
        }
        if self == Self::Exr && settings.sharpening != 0.0 {
            let message = "sharpening works on what is shown, not on the linear light of an EXR file";
            return Err(Invalid::new("sharpening", message).help("write a .png or .tiff file"));
        }
        Ok(())
    }
}

/// Writes a picture of codes as PNG. The picture must have pixels.
pub fn write_png<W: Write>(picture: &EncodedPicture, to: W) -> io::Result<()> {
    encode_with(PngEncoder::new(to), picture)
}

/// Writes a picture of codes in a format other than EXR.
pub fn write_encoded(picture: &EncodedPicture, format: PictureFormat, to: &mut dyn Sink) -> io::Result<()> {
    match format {
        PictureFormat::Png => write_png(picture, to),
        PictureFormat::Tiff => encode_with(TiffEncoder::new(to), picture),
        PictureFormat::Jpeg => encode_with(JpegEncoder::new_with_quality(to, 95), picture),
        PictureFormat::Ppm => write_ppm(picture, to),
        PictureFormat::Exr => Err(io::Error::other("an EXR file holds linear values, not codes")),
    }
}

/// Writes linear planes as EXR, with the chromaticities of their colour space.
pub fn write_linear<W: Write + Seek>(planes: &Planes, space: ColourSpace, to: W) -> io::Result<()> {
    let attributes = [("colorSpace", Attribute::Text(space.name().to_owned()))];
    write_exr(planes, &attributes, to)
}

fn encode_with(mut encoder: impl ImageEncoder, picture: &EncodedPicture) -> io::Result<()> {
    encoder.set_icc_profile(icc_profile(picture)?).map_err(io::Error::other)?;
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let (width, height) = (side(picture.width)?, side(picture.height)?);
    let grey = picture.components == 1;
    let (bytes, colour) = match &picture.codes {
        Codes::U8(codes) => (codes.clone(), if grey { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 }),
        Codes::U16(codes) => {
            let bytes = codes.iter().flat_map(|code| code.to_ne_bytes()).collect();
            (bytes, if grey { ExtendedColorType::L16 } else { ExtendedColorType::Rgb16 })
        }
    };
    encoder.write_image(&bytes, width, height, colour).map_err(|error| {
        let ImageError::IoError(error) = error else { return io::Error::other(error) };
        error
    })
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
            to.write_all(&codes.iter().flat_map(|code| code.to_be_bytes()).collect::<Vec<u8>>())
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::colour::Transfer;

    fn picture(components: usize, bits: u8) -> EncodedPicture {
        let n = 5 * 4 * components;
        let codes = if bits == 8 {
            Codes::U8((0..n).map(|i| (i * 13) as u8).collect())
        } else {
            Codes::U16((0..n).map(|i| (i * 4099) as u16).collect())
        };
        let (colour_space, transfer) = (ColourSpace::DisplayP3, Transfer::Srgb);
        EncodedPicture { width: 5, height: 4, components, codes, colour_space, transfer }
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
        let mut jpeg = Cursor::new(Vec::new());
        write_encoded(&picture(3, 8), PictureFormat::Jpeg, &mut jpeg).expect("written");
        assert_eq!(image::load_from_memory(jpeg.get_ref()).expect("a picture").width(), 5);
    }

    #[test]
    fn names_say_the_format() {
        for (name, format) in
            [("a.png", PictureFormat::Png), ("b.TIF", PictureFormat::Tiff), ("c.jpeg", PictureFormat::Jpeg)]
        {
            assert_eq!(PictureFormat::of(name.as_ref()).expect("known"), format);
        }
        assert!(PictureFormat::of("raw.dng".as_ref()).is_err() && PictureFormat::of("picture".as_ref()).is_err());
        let deep = DevelopSettings { bits: 16, ..DevelopSettings::default() };
        assert_eq!(PictureFormat::Jpeg.check(&deep).expect_err("8 bits").key, "bits");
        let xyz = DevelopSettings { colour_space: ColourSpace::Xyz, ..DevelopSettings::default() };
        assert_eq!(PictureFormat::Png.check(&xyz).expect_err("passes 1").key, "colour_space");
        assert!(PictureFormat::Exr.check(&xyz).is_ok());
    }
}
