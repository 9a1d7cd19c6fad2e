//! Pictures of plain numbers, written as they are in the format that the file's name says.
//!
//! | extension | holds |
//! |---|---|
//! | `.png` | whole numbers of 8 or 16 bits, of 1–4 channels |
//! | `.tif`, `.tiff` | the same, or 32-bit floats; of 1, 3 or 4 channels |
//! | `.pgm`, `.ppm`, `.pnm` | whole numbers up to any largest one; of 1 or 3 channels |
//! | `.npy` | whole numbers of 8 or 16 bits, or 32-bit floats |
//! | `.exr` | 32-bit floats |

use std::io::{self, Write};
use std::path::Path;

use png::{BitDepth, ColorType};
use tiff::TiffResult;
use tiff::encoder::colortype::{self, ColorType as TiffColourType};
use tiff::encoder::{ImageEncoder, TiffEncoder, TiffKindStandard, TiffValue};
use tiff::tags::Tag;

use super::developed::tiff_error;
use super::exr::{Attribute, write_exr};
use super::npy::write_planes;
use super::output::Sink;
use crate::image::Planes;
use crate::{Error, Invalid, Result};

/// Formats of pictures of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberFormat {
    /// Portable network graphics.
    Png,
    /// Tagged image file format.
    Tiff,
    /// Portable greymap.
    Pgm,
    /// Portable pixmap, or greymap.
    Ppm,
    /// A NumPy array.
    Npy,
    /// OpenEXR.
    Exr,
}

/// A picture of numbers.
#[derive(Clone, Debug)]
pub struct NumberPicture {
    /// Its channels; `A` is transparency.
    pub planes: Planes,
    /// The largest number, of whole ones.
    pub largest: Option<u16>,
    /// What its colours mean, as an ICC profile, for PNG and TIFF.
    pub profile: Option<Vec<u8>>,
    /// What an EXR file says besides.
    pub attributes: Vec<(String, Attribute)>,
}

impl NumberFormat {
    /// The format that a file's name says.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "png" => Ok(Self::Png),
            "tif" | "tiff" => Ok(Self::Tiff),
            "pgm" => Ok(Self::Pgm),
            "ppm" | "pnm" => Ok(Self::Ppm),
            "npy" => Ok(Self::Npy),
            "exr" => Ok(Self::Exr),
            _ => Err(Error::Usage {
                message: format!("{} is not the name of a picture whose numbers stay as they are", path.display()),
                help: Some("give a name that ends with .png, .tiff, .pgm, .ppm, .npy or .exr".into()),
            }),
        }
    }

    /// Whether it holds whole numbers as such.
    pub fn holds_whole_numbers(self) -> bool {
        self != Self::Exr
    }

    /// Refuses a picture that the format cannot hold.
    pub fn check(self, picture: &NumberPicture) -> Result<(), Invalid> {
        let refuse = |message: String, help: &str| Err(Invalid::new("", message).help(help));
        let channels = picture.planes.channels().len();
        let (format, most): (_, &[usize]) = match self {
            Self::Png => ("a PNG file", &[1, 2, 3, 4]),
            Self::Tiff => ("a TIFF file", &[1, 3, 4]),
            Self::Pgm => ("a PGM file", &[1]),
            Self::Ppm => ("a PPM file", &[1, 3]),
            Self::Npy | Self::Exr => return Ok(()),
        };
        if !most.contains(&channels) {
            let names: Vec<&str> = picture.planes.channels().iter().map(|c| &c.name[..]).collect();
            return refuse(
                format!("{format} does not hold the channels {}", names.join(", ")),
                "write an .exr or .npy file",
            );
        }
        match picture.largest {
            None if self != Self::Tiff => {
                refuse(format!("{format} holds whole numbers, and these are none"), "write an .exr, .tiff or .npy file")
            }
            Some(largest)
                if ![u16::from(u8::MAX), u16::MAX].contains(&largest) && matches!(self, Self::Png | Self::Tiff) =>
            {
                let message = format!("the numbers reach to {largest}, which {format} cannot express");
                refuse(message, "write a .pgm, .ppm, .npy or .exr file")
            }
            None | Some(_) => Ok(()),
        }
    }
}

/// Writes a picture that [`NumberFormat::check`] lets pass; whole numbers must be rounded.
pub fn write_numbers(picture: &NumberPicture, format: NumberFormat, to: &mut dyn Sink) -> io::Result<()> {
    match format {
        NumberFormat::Png => write_png(picture, to),
        NumberFormat::Tiff => write_tiff(picture, to),
        NumberFormat::Pgm | NumberFormat::Ppm => write_pnm(picture, to),
        NumberFormat::Npy => write_npy(picture, to),
        NumberFormat::Exr => {
            let attributes: Vec<(&str, Attribute)> =
                picture.attributes.iter().map(|(name, value)| (&name[..], value.clone())).collect();
            write_exr(&picture.planes, &attributes, to)
        }
    }
}

impl NumberPicture {
    fn size(&self) -> io::Result<[u32; 2]> {
        let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
        Ok([side(self.planes.width())?, side(self.planes.height())?])
    }

    /// All numbers, those of a pixel beside each other.
    fn interleaved<T>(&self, number: impl Fn(f32) -> T) -> Vec<T> {
        let channels = self.planes.channels();
        let pixels = self.planes.width() * self.planes.height();
        (0..pixels).flat_map(|i| channels.iter().map(move |c| c.data[i])).map(number).collect()
    }

    /// Whether a number takes one byte.
    fn is_narrow(&self) -> bool {
        self.largest.is_some_and(|largest| largest <= u8::MAX.into())
    }

    /// Whole numbers as bytes, of two the more significant one first.
    fn bytes(&self) -> Vec<u8> {
        if self.is_narrow() {
            self.interleaved(|v| v as u8)
        } else {
            self.interleaved(|v| (v as u16).to_be_bytes()).into_flattened()
        }
    }
}

fn write_png(picture: &NumberPicture, to: &mut dyn Sink) -> io::Result<()> {
    let [width, height] = picture.size()?;
    let mut info = png::Info::with_size(width, height);
    info.color_type = match picture.planes.channels().len() {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    };
    info.bit_depth = if picture.is_narrow() { BitDepth::Eight } else { BitDepth::Sixteen };
    info.icc_profile = picture.profile.clone().map(Into::into);
    let mut writer = png::Encoder::with_info(to, info)?.write_header()?;
    writer.write_image_data(&picture.bytes())?;
    Ok(writer.finish()?)
}

fn write_tiff(picture: &NumberPicture, to: &mut dyn Sink) -> io::Result<()> {
    let [width, height] = picture.size()?;
    let mut file = TiffEncoder::new(to).map_err(tiff_error)?;
    let (narrow, wide) = (|v: f32| v as u8, |v: f32| v as u16);
    let profile = picture.profile.as_deref();
    let mut write = || match (picture.largest, picture.is_narrow(), picture.planes.channels().len()) {
        (None, _, 1) => {
            finish::<colortype::Gray32Float>(file.new_image(width, height), profile, &picture.interleaved(|v| v))
        }
        (None, _, 3) => {
            finish::<colortype::RGB32Float>(file.new_image(width, height), profile, &picture.interleaved(|v| v))
        }
        (None, _, _) => {
            finish::<colortype::RGBA32Float>(file.new_image(width, height), profile, &picture.interleaved(|v| v))
        }
        (Some(_), true, 1) => {
            finish::<colortype::Gray8>(file.new_image(width, height), profile, &picture.interleaved(narrow))
        }
        (Some(_), true, 3) => {
            finish::<colortype::RGB8>(file.new_image(width, height), profile, &picture.interleaved(narrow))
        }
        (Some(_), true, _) => {
            finish::<colortype::RGBA8>(file.new_image(width, height), profile, &picture.interleaved(narrow))
        }
        (Some(_), false, 1) => {
            finish::<colortype::Gray16>(file.new_image(width, height), profile, &picture.interleaved(wide))
        }
        (Some(_), false, 3) => {
            finish::<colortype::RGB16>(file.new_image(width, height), profile, &picture.interleaved(wide))
        }
        (Some(_), false, _) => {
            finish::<colortype::RGBA16>(file.new_image(width, height), profile, &picture.interleaved(wide))
        }
    };
    write().map_err(tiff_error)
}

fn finish<C: TiffColourType>(
    image: TiffResult<ImageEncoder<'_, &mut dyn Sink, C, TiffKindStandard>>,
    profile: Option<&[u8]>,
    numbers: &[C::Inner],
) -> TiffResult<()>
where
    [C::Inner]: TiffValue,
{
    let mut image = image?;
    if let Some(profile) = profile {
        image.encoder().write_tag(Tag::IccProfile, profile)?;
    }
    image.write_data(numbers)
}

fn write_pnm(picture: &NumberPicture, to: &mut dyn Sink) -> io::Result<()> {
    let kind = if picture.planes.channels().len() == 1 { "P5" } else { "P6" };
    let [width, height] = picture.size()?;
    write!(to, "{kind}\n{width} {height}\n{}\n", picture.largest.unwrap_or(u16::MAX))?;
    to.write_all(&picture.bytes())
}

fn write_npy<W: Write>(picture: &NumberPicture, to: W) -> io::Result<()> {
    let size = [picture.planes.width(), picture.planes.height()];
    let planes: Vec<&[f32]> = picture.planes.channels().iter().map(|channel| &channel.data[..]).collect();
    match picture.largest {
        None => write_planes(size, &planes, |v| v, to),
        Some(_) if picture.is_narrow() => write_planes(size, &planes, |v| v as u8, to),
        Some(_) => write_planes(size, &planes, |v| v as u16, to),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channel;
    use crate::io::output::write_whole;
    use crate::io::picture_file::read_picture_file;
    use crate::raw::Pixels;

    fn picture(names: &[&str], largest: Option<u16>) -> NumberPicture {
        let scale = largest.map_or(0.37, |largest| f32::from((largest / 11).max(1)));
        let channel = |(i, name): (usize, &&str)| Channel {
            name: (*name).to_owned(),
            data: (0..6).map(|k| scale * (k + i) as f32).collect(),
        };
        let planes = Planes::new(3, 2, names.iter().enumerate().map(channel).collect()).expect("right sizes");
        NumberPicture { planes, largest, profile: None, attributes: Vec::new() }
    }

    #[test]
    fn numbers_come_back_from_every_format() {
        let folder = tempfile::tempdir().expect("a folder");
        let channels: [&[&str]; 4] = [&["Y"], &["Y", "A"], &["R", "G", "B"], &["R", "G", "B", "A"]];
        for names in channels {
            for largest in [Some(255), Some(1023), Some(65_535), None] {
                let picture = picture(names, largest);
                for extension in ["png", "tiff", "pgm", "ppm", "npy", "exr"] {
                    let path = folder.path().join(format!("picture.{extension}"));
                    let format = NumberFormat::of(&path).expect("known");
                    if format.check(&picture).is_err() {
                        continue;
                    }
                    write_whole(&path, |to| write_numbers(&picture, format, to)).expect("written");
                    let found = read_picture_file(&path, Pixels::Active).expect("read");
                    for (i, channel) in picture.planes.channels().iter().enumerate() {
                        // Readers call grey of 16 bits otherwise, and EXR sorts by name.
                        let found = found.mean.plane(&channel.name).unwrap_or(&found.mean.channels()[i].data);
                        assert_eq!(found, channel.data, "{names:?} to {largest:?} as {extension}");
                    }
                    if format.holds_whole_numbers() && extension != "npy" {
                        assert_eq!(found.full_scale, largest.map(f64::from), "{extension}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_a_format_cannot_hold_is_refused() {
        let check = |format: NumberFormat, names: &[&str], largest| format.check(&picture(names, largest));
        for (refused, message) in [
            (check(NumberFormat::Png, &["Y"], None), "whole numbers"),
            (check(NumberFormat::Png, &["Y"], Some(1023)), "reach to 1023"),
            (check(NumberFormat::Tiff, &["Y", "A"], Some(255)), "channels Y, A"),
            (check(NumberFormat::Pgm, &["R", "G", "B"], Some(255)), "channels R, G, B"),
            (check(NumberFormat::Ppm, &["Y"], None), "whole numbers"),
        ] {
            assert!(refused.expect_err("refused").message.contains(message));
        }
        assert!(NumberFormat::of(Path::new("a.jpg")).is_err());
    }
}
