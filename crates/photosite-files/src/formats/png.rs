//! PNG files. Colours are stated twice: by the ICC profile, and by code points (cICP) where there are such, which screens
//! of more than sRGB go by ([Png3](photosite_core::references#png3)).

use std::fs::File;
use std::io::{self, BufReader, Write};

use png::{BitDepth, ColorType, Compression, Info};

use super::decoded::{ImageFile, of_codes};
use super::{FileImage, Samples};
use crate::image_notes;
use photosite_core::Invalid;
use photosite_raw::Pixels;

pub(super) fn read(file: &mut BufReader<File>, name: String, _: Pixels) -> Result<ImageFile, Invalid> {
    of_codes(file, name, "PNG", image_notes::of_png)
}

/// Writes integers of 1–4 channels.
pub(crate) fn write<W: Write>(image: &FileImage<'_>, to: W) -> io::Result<()> {
    let [width, height] = image.sides()?;
    let mut info = Info::with_size(width, height);
    info.color_type = match image.channels {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    };
    info.bit_depth = if matches!(image.samples, Samples::U8(_)) { BitDepth::Eight } else { BitDepth::Sixteen };
    image.colours.write_png(&mut info);
    info.pixel_dims =
        image.not_square().map(|[xppu, yppu]| png::PixelDimensions { xppu, yppu, unit: png::Unit::Unspecified });
    let mut encoder = png::Encoder::with_info(to, info)?;
    encoder.set_compression(if image.is_fast { Compression::Fast } else { Compression::Balanced });
    let mut writer = encoder.write_header()?;
    if let Some([primaries, transfer]) = image.colours.code_points {
        // RGB rather than luma and chroma, and all codes used.
        writer.write_chunk(png::chunk::cICP, &[primaries, transfer, 0, 1])?;
    }
    writer.write_image_data(&image.big_endian()?)?;
    Ok(writer.finish()?)
}
