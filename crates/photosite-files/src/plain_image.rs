//! Images of plain pixel values, written unchanged in the format of the file name's extension.

use std::borrow::Cow;
use std::io;
use std::path::Path;

use super::formats::{FileImage, Format, Samples, lists::written};
use super::image_file::ImageFile;
use super::stated_colours::StatedColours;
use photosite_core::image::Planes;
use photosite_core::output::Sink;
use photosite_core::{Invalid, Result};
use photosite_raw::Pixels;

/// Image of plain pixel values.
#[derive(Clone, Debug)]
pub struct PlainImage {
    /// Channels; `A` is transparency.
    pub planes: Planes,
    /// Largest value, for integers.
    pub largest: Option<u16>,
    /// Statements of colours, and attributes of an EXR file.
    pub colours: StatedColours,
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
}

impl PlainImage {
    /// Pixel values of which nothing is stated.
    pub fn plain(planes: Planes, largest: Option<u16>) -> Self {
        Self { planes, largest, colours: StatedColours::default(), pixel_aspect: 1.0 }
    }

    /// Reads the pixel values of a file with its statements of colours and of the shape of pixels, and warnings of what
    /// is left out.
    pub fn read(path: &Path) -> Result<(Self, Vec<String>)> {
        let ImageFile { image, mut notes } = ImageFile::read(path, Pixels::All)?;
        let colours = std::mem::take(&mut notes.colours);
        let pixel_aspect = notes.pixel_aspect.take().unwrap_or(1.0);
        let warnings = image.said().chain(notes.of_pixels_as_they_lie(&image.name)).collect();
        let plain = Self::plain(image.mean, image.full_scale.map(|largest| largest as u16));
        Ok((Self { colours, pixel_aspect, ..plain }, warnings))
    }
}

/// Formats of plain pixel values, which change none.
impl Format {
    /// Format of plain pixel values of that name.
    pub fn of_numbers(path: &Path) -> Result<&'static Self> {
        written(path, Self::keeps_numbers, "an image whose pixel values stay as they are")
    }

    /// Whether the format holds integers as such.
    pub fn holds_whole_numbers(&self) -> bool {
        !self.bits.is_empty()
    }

    /// Refuses pixel values that the format cannot hold.
    pub fn check_numbers(&self, image: &PlainImage) -> Result<(), Invalid> {
        let refuse = |message: String, help: &str| Err(Invalid::new("", message).help(help));
        let format = format!("a {} file", self.name);
        if !self.holds_channels(image.planes.channels().len()) {
            let names: Vec<&str> = image.planes.channels().iter().map(|c| &c.name[..]).collect();
            return refuse(
                format!("{format} does not hold the channels {}", names.join(", ")),
                "write an .exr or .npy file",
            );
        }
        match image.largest {
            None if !self.floats => {
                refuse(format!("{format} holds whole numbers, and these are none"), "write an .exr, .tiff or .npy file")
            }
            Some(largest)
                if !self.bits.is_empty() && !self.any_largest && ![u16::from(u8::MAX), u16::MAX].contains(&largest) =>
            {
                let message = format!("the pixel values reach to {largest}, which {format} cannot express");
                refuse(message, "write a .pgm, .ppm, .npy or .exr file")
            }
            None | Some(_) => Ok(()),
        }
    }
}

/// Writes an image that [`Format::check_numbers`] accepts; integers must be rounded.
pub fn write_plain_image(image: &PlainImage, format: &Format, to: &mut dyn Sink) -> io::Result<()> {
    let &PlainImage { ref planes, largest, ref colours, pixel_aspect } = image;
    let channels = planes.channels();
    let values = || (0..planes.width() * planes.height()).flat_map(|i| channels.iter().map(move |c| c.data[i]));
    let image = FileImage::of_planes(planes);
    let samples = match largest {
        Some(largest) if format.holds_whole_numbers() && largest <= u8::MAX.into() => {
            Samples::U8(values().map(|v| v as u8).collect())
        }
        Some(_) if format.holds_whole_numbers() => Samples::U16(values().map(|v| v as u16).collect()),
        Some(_) | None => image.samples,
    };
    let largest = largest.unwrap_or(u16::MAX);
    format.write(&FileImage { samples, largest, pixel_aspect, colours: Cow::Borrowed(colours), ..image }, to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::developed::write_png;
    use crate::formats::{PGM, PNG, PPM, TIFF};
    use crate::image_file::read_image_file;
    use photosite_core::colour::ColourSpace;
    use photosite_core::image::Channel;
    use photosite_core::output::write_whole;
    use photosite_develop::{Codes, EncodedImage};

    fn image(names: &[&str], largest: Option<u16>) -> PlainImage {
        let scale = largest.map_or(0.37, |largest| f32::from((largest / 11).max(1)));
        let channel = |(i, name): (usize, &&str)| Channel {
            name: (*name).to_owned(),
            data: (0..6).map(|k| scale * (k + i) as f32).collect(),
        };
        let planes = Planes::new(3, 2, names.iter().enumerate().map(channel).collect()).expect("right sizes");
        PlainImage::plain(planes, largest)
    }

    #[test]
    fn numbers_come_back_from_every_format() {
        let folder = tempfile::tempdir().expect("a folder");
        let channels: [&[&str]; 4] = [&["Y"], &["Y", "A"], &["R", "G", "B"], &["R", "G", "B", "A"]];
        for names in channels {
            for largest in [Some(255), Some(1023), Some(65_535), None] {
                let image = image(names, largest);
                for extension in ["png", "tiff", "pgm", "ppm", "npy", "exr"] {
                    let path = folder.path().join(format!("picture.{extension}"));
                    let format = Format::of_numbers(&path).expect("known");
                    if format.check_numbers(&image).is_err() {
                        continue;
                    }
                    write_whole(&path, |to| write_plain_image(&image, format, to)).expect("written");
                    let found = read_image_file(&path, Pixels::Active).expect("read");
                    for (i, channel) in image.planes.channels().iter().enumerate() {
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
    fn codes_and_their_meaning_go_along() {
        let folder = tempfile::tempdir().expect("a folder");
        for codes in [Codes::U8((0..18).map(|i| 14 * i).collect()), Codes::U16((0..18).map(|i| 3855 * i).collect())] {
            let image = EncodedImage {
                colour_space: ColourSpace::DisplayP3,
                codes,
                pixel_aspect: 2.0,
                ..EncodedImage::srgb8(2, 3, 3, Vec::new())
            };
            let [first, second] = ["a.png", "b.png"].map(|name| folder.path().join(name));
            write_whole(&first, |to| write_png(&image, to)).expect("written");
            let (read, _) = PlainImage::read(&first).expect("read");
            write_whole(&second, |to| write_plain_image(&read, &PNG, to)).expect("written");
            let (copy, _) = PlainImage::read(&second).expect("read");
            assert_eq!((&read.planes, read.largest), (&copy.planes, copy.largest));
            assert!(copy.colours.profile.is_some() && copy.colours == read.colours);
            assert_eq!((copy.colours.code_points, copy.pixel_aspect), (Some([12, 13]), 2.0));
        }
    }

    #[test]
    fn what_a_format_cannot_hold_is_refused() {
        let check = |format: Format, names: &[&str], largest| format.check_numbers(&image(names, largest));
        for (refused, message) in [
            (check(PNG, &["Y"], None), "whole numbers"),
            (check(PNG, &["Y"], Some(1023)), "reach to 1023"),
            (check(TIFF, &["Y", "A"], Some(255)), "channels Y, A"),
            (check(PGM, &["R", "G", "B"], Some(255)), "channels R, G, B"),
            (check(PPM, &["Y"], None), "whole numbers"),
        ] {
            assert!(refused.expect_err("refused").message.contains(message));
        }
        assert!(Format::of_numbers(Path::new("a.jpg")).is_err());
    }
}
