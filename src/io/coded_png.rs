//! PNG pictures of codes that become other pictures with the same meaning: what a file says of its colours goes along.

use std::io::{self, BufReader, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Info};

use crate::image::{Channel, Planes};
use crate::{Error, Invalid, Result, memory};
use photosite_core::input;

/// A picture of codes, grey or RGB.
#[derive(Clone, Debug)]
pub struct CodedPng {
    /// Codes from 0 to [`full_scale`](Self::full_scale): Y, or R, G and B.
    pub planes: Planes,
    /// What the file says.
    info: Info<'static>,
}

impl CodedPng {
    /// Reads a file of 8 or 16 bits, grey or RGB, as photosite writes them.
    pub fn read(path: &Path) -> Result<Self> {
        let file = input::open(path).map_err(|source| Error::io(path, "read", source))?;
        Self::decode(BufReader::new(file)).map_err(|invalid| invalid.in_file(path))
    }

    fn decode(file: impl io::BufRead + io::Seek) -> Result<Self, Invalid> {
        let unreadable = |error: &dyn std::fmt::Display| Invalid::new("", format!("cannot read it as PNG: {error}"));
        let mut reader = png::Decoder::new(file).read_info().map_err(|e| unreadable(&e))?;
        let info = reader.info().clone();
        let names: &[&str] = match info.color_type {
            ColorType::Grayscale => &["Y"],
            ColorType::Rgb => &["R", "G", "B"],
            ColorType::Indexed | ColorType::GrayscaleAlpha | ColorType::Rgba => {
                return Err(unreadable(&"it is neither grey nor RGB"));
            }
        };
        let size = [info.width, info.height].map(|n| n as usize);
        let floats = (size[0] as u64).saturating_mul(size[1] as u64).saturating_mul(4 * names.len() as u64);
        memory::check(floats.saturating_mul(2), &format!("reading its {} × {} pixels", size[0], size[1]), "")?;
        let mut bytes = vec![0; reader.output_buffer_size().ok_or_else(|| unreadable(&"it is too large"))?];
        reader.next_frame(&mut bytes).map_err(|e| unreadable(&e))?;
        let codes: Vec<f32> = match info.bit_depth {
            BitDepth::Eight => bytes.into_iter().map(f32::from).collect(),
            BitDepth::Sixteen => {
                bytes.as_chunks::<2>().0.iter().map(|&pair| f32::from(u16::from_be_bytes(pair))).collect()
            }
            BitDepth::One | BitDepth::Two | BitDepth::Four => return Err(unreadable(&"it has fewer than 8 bits")),
        };
        let plane = |(i, name): (usize, &&str)| Channel {
            name: (*name).to_owned(),
            data: codes.iter().skip(i).step_by(names.len()).copied().collect(),
        };
        let planes = Planes::new(size[0], size[1], names.iter().enumerate().map(plane).collect())?;
        Ok(Self { planes, info })
    }

    /// The code of white.
    pub fn full_scale(&self) -> f32 {
        if self.info.bit_depth == BitDepth::Sixteen { f32::from(u16::MAX) } else { f32::from(u8::MAX) }
    }

    /// Writes other codes of the same meaning, rounded and kept within 0 and full scale.
    pub fn write<W: Write>(&self, planes: &Planes, to: W) -> io::Result<()> {
        let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
        let mut info = self.info.clone();
        (info.width, info.height, info.interlaced) = (side(planes.width())?, side(planes.height())?, false);
        let (full_scale, channels) = (self.full_scale(), planes.channels());
        let code = |i: usize| channels.iter().map(move |channel| channel.data[i].round().clamp(0.0, full_scale));
        let codes = (0..planes.width() * planes.height()).flat_map(code);
        let bytes: Vec<u8> = if self.info.bit_depth == BitDepth::Sixteen {
            codes.flat_map(|code| (code as u16).to_be_bytes()).collect()
        } else {
            codes.map(|code| code as u8).collect()
        };
        let code_points = info.coding_independent_code_points;
        let mut writer = png::Encoder::with_info(to, info)?.write_header()?;
        if let Some(points) = code_points {
            let range = u8::from(points.is_video_full_range_image);
            let numbers = [points.color_primaries, points.transfer_function, points.matrix_coefficients, range];
            writer.write_chunk(png::chunk::cICP, &numbers)?;
        }
        writer.write_image_data(&bytes)?;
        Ok(writer.finish()?)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::colour::{ColourSpace, Transfer};
    use crate::develop::{Codes, EncodedPicture};
    use crate::io::developed::write_png;

    #[test]
    fn codes_and_their_meaning_go_along() {
        let codes =
            [Codes::U8((0..2 * 3 * 3).map(|i| 14 * i).collect()), Codes::U16((0..18).map(|i| 3855 * i).collect())];
        for codes in codes {
            let picture = EncodedPicture {
                width: 2,
                height: 3,
                components: 3,
                codes,
                colour_space: ColourSpace::DisplayP3,
                transfer: Transfer::Srgb,
                pixel_aspect: 2.0,
            };
            let mut file = Vec::new();
            write_png(&picture, &mut file).expect("written");
            let read = CodedPng::decode(Cursor::new(&file)).expect("a picture");
            let mut again = Vec::new();
            read.write(&read.planes, &mut again).expect("written");
            let copy = CodedPng::decode(Cursor::new(&again)).expect("a picture");
            assert_eq!((&read.planes, read.full_scale()), (&copy.planes, copy.full_scale()));
            assert!(copy.info.icc_profile.is_some() && copy.info.icc_profile == read.info.icc_profile);
            let points = |png: &CodedPng| {
                png.info.coding_independent_code_points.map(|p| (p.color_primaries, p.transfer_function))
            };
            assert_eq!((points(&copy), points(&read)), (Some((12, 13)), Some((12, 13))));
            let pixels = |png: &CodedPng| png.info.pixel_dims.map(|p| [p.xppu, p.yppu]);
            assert_eq!((pixels(&copy), pixels(&read)), (Some([500_000, 1_000_000]), Some([500_000, 1_000_000])));
        }
    }
}
