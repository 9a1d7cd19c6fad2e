//! NumPy arrays of shape (rows, columns), or (rows, columns, channels) where there are several.

use std::fs::File;
use std::io::{self, BufReader, Write};

use npyz::{AutoSerialize, WriterBuilder};

use super::formats::{FileImage, ImageFile, Samples, interleaved};
use photosite_core::Invalid;
use photosite_core::output::Sink;
use photosite_measure::validation::ComparedImage;
use photosite_raw::{NpyImage, NpyValues, Pixels, read_npy_image};

pub(super) fn read(file: &mut BufReader<File>, name: String, _: Pixels) -> Result<ImageFile, Invalid> {
    let NpyImage { width, height, channels, numbers } = read_npy_image(file)?;
    let size = [width, height];
    let image = match numbers {
        NpyValues::U8(v) => interleaved(name, size, channels, v.into_iter().map(f32::from), Some(u8::MAX.into())),
        NpyValues::U16(v) => {
            let image = interleaved(name, size, channels, v.into_iter().map(f32::from), Some(u16::MAX))?;
            Ok(ComparedImage { unit: Some("DN".to_owned()), ..image })
        }
        NpyValues::F32(v) => interleaved(name, size, channels, v.into_iter(), None),
    };
    image.map(ImageFile::silent)
}

pub(super) fn write(image: &FileImage<'_>, to: &mut dyn Sink) -> io::Result<()> {
    match &image.samples {
        Samples::U8(codes) => write_array(image.size, image.channels, codes.iter().copied(), to),
        Samples::U16(codes) => write_array(image.size, image.channels, codes.iter().copied(), to),
        Samples::F32(planes) => {
            let planes: Vec<&[f32]> = planes.channels().iter().map(|channel| &channel.data[..]).collect();
            write_planes(image.size, &planes, |value| value, to)
        }
    }
}

/// Writes planes of `width` columns and `height` rows as an array, each value converted by `number`.
pub fn write_planes<V: Copy, T: AutoSerialize, W: Write>(
    size: [usize; 2],
    planes: &[&[V]],
    number: impl Fn(V) -> T,
    to: W,
) -> io::Result<()> {
    let values = (0..size[0] * size[1]).flat_map(|i| planes.iter().map(move |plane| plane[i])).map(number);
    write_array(size, planes.len(), values, to)
}

fn write_array<T: AutoSerialize, W: Write>(
    [width, height]: [usize; 2],
    channels: usize,
    values: impl Iterator<Item = T>,
    to: W,
) -> io::Result<()> {
    let shape = [height, width, channels].map(|n| n as u64);
    let shape = if channels == 1 { &shape[..2] } else { &shape[..] };
    let mut array = npyz::WriteOptions::new().default_dtype().shape(shape).writer(to).begin_nd()?;
    array.extend(values)?;
    array.finish()
}
