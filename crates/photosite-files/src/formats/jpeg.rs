//! JPEG files, of 8 bits.

use std::fs::File;
use std::io::{self, BufReader};

use image::codecs::jpeg::{JpegEncoder, PixelDensity, PixelDensityUnit};
use image::{ExtendedColorType, ImageEncoder as _, ImageError};

use super::decoded::{ImageFile, of_codes};
use super::{FileImage, Samples};
use crate::image_notes;
use photosite_core::Invalid;
use photosite_core::output::Sink;
use photosite_raw::Pixels;

pub(super) fn read(file: &mut BufReader<File>, name: String, _: Pixels) -> Result<ImageFile, Invalid> {
    of_codes(file, name, "JPEG", |bytes| Ok(image_notes::of_jpeg(bytes)))
}

pub(super) fn write(image: &FileImage<'_>, to: &mut dyn Sink) -> io::Result<()> {
    let Samples::U8(codes) = &image.samples else { return Err(io::Error::other("a JPEG file has 8 bits")) };
    let mut encoder = JpegEncoder::new_with_quality(to, image.jpeg_quality);
    if let Some([x, y]) = image.not_square() {
        // As near as 16 bits come.
        let density = [x, y].map(|n| (f64::from(n) * (65_535.0 / f64::from(x.max(y)))).round() as u16);
        encoder.set_pixel_density(PixelDensity {
            density: (density[0], density[1]),
            unit: PixelDensityUnit::PixelAspectRatio,
        });
    }
    if let Some(profile) = &image.colours.profile {
        encoder.set_icc_profile(profile.clone()).map_err(io::Error::other)?;
    }
    let [width, height] = image.sides()?;
    let colour = if image.channels == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
    encoder.write_image(codes, width, height, colour).map_err(|error| {
        let ImageError::IoError(error) = error else { return io::Error::other(error) };
        error
    })
}
