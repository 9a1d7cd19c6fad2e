//! TIFF files: uncompressed integers or floats of grey or colours, or floats of anything else.

use std::fs::File;
use std::io::{self, BufReader, Seek};

use tiff::ColorType::{Gray, GrayA, RGB, RGBA};
use tiff::decoder::{Decoder, DecodingResult};
use tiff::encoder::colortype::{
    ColorType, Gray8, Gray16, Gray32Float, RGB8, RGB16, RGB32Float, RGBA8, RGBA16, RGBA32Float,
};
use tiff::encoder::{Rational, TiffEncoder, TiffValue};
use tiff::tags::{ExtraSamples, ResolutionUnit, Tag};
use tiff::{TiffError, TiffResult};

use super::decoded::{ImageFile, interleaved, unreadable};
use super::{FileImage, Samples};
use crate::image_notes;
use photosite_core::Invalid;
use photosite_core::image::Planes;
use photosite_core::output::Sink;
use photosite_raw::{Pixels, read_pixels, refuse_planar_tiles};

pub(super) fn read(file: &mut BufReader<File>, name: String, _: Pixels) -> Result<ImageFile, Invalid> {
    let bad = |error: TiffError| unreadable("TIFF", &error);
    let notes = image_notes::of_tiff(&mut *file)?;
    file.rewind().map_err(|error| bad(error.into()))?;
    let mut decoder = Decoder::new(file).map_err(bad)?;
    let (width, height) = decoder.dimensions().map_err(bad)?;
    let size = [width as usize, height as usize];
    let colours = decoder.colortype().map_err(bad)?;
    let refused = || {
        Invalid::new("", format!("pixels of the kind {colours:?} cannot be compared"))
            .help("write grey or RGB, of 8 or 16 bits or of 32-bit floats")
    };
    let grey_or_rgb = matches!(colours, Gray(_) | GrayA(_) | RGB(_) | RGBA(_));
    if !grey_or_rgb || ![8, 16, 32, 64].contains(&colours.bit_depth()) {
        return Err(refused());
    }
    let components = usize::from(colours.num_samples());
    refuse_planar_tiles(&mut decoder).map_err(bad)??;
    let image = match read_pixels(&mut decoder).map_err(bad)? {
        DecodingResult::U8(v) => {
            interleaved(name, size, components, v.into_iter().map(f32::from), Some(u8::MAX.into()))
        }
        DecodingResult::U16(v) => interleaved(name, size, components, v.into_iter().map(f32::from), Some(u16::MAX)),
        DecodingResult::F32(v) => interleaved(name, size, components, v.into_iter(), None),
        DecodingResult::F64(v) => interleaved(name, size, components, v.into_iter().map(|x| x as f32), None),
        DecodingResult::U32(_)
        | DecodingResult::U64(_)
        | DecodingResult::F16(_)
        | DecodingResult::I8(_)
        | DecodingResult::I16(_)
        | DecodingResult::I32(_)
        | DecodingResult::I64(_) => Err(refused()),
    };
    Ok(ImageFile { image: image?, notes })
}

pub(super) fn write(image: &FileImage<'_>, to: &mut dyn Sink) -> io::Result<()> {
    let written = match (&image.samples, image.channels) {
        (Samples::U8(codes), 1) => encode::<Gray8>(image, codes, to),
        (Samples::U8(codes), 3) => encode::<RGB8>(image, codes, to),
        (Samples::U8(codes), _) => encode::<RGBA8>(image, codes, to),
        (Samples::U16(codes), 1) => encode::<Gray16>(image, codes, to),
        (Samples::U16(codes), 3) => encode::<RGB16>(image, codes, to),
        (Samples::U16(codes), _) => encode::<RGBA16>(image, codes, to),
        (Samples::F32(planes), 3) if image.description.is_none() => {
            encode::<RGB32Float>(image, &pixel_by_pixel(planes), to)
        }
        (Samples::F32(planes), 4) if image.description.is_none() => {
            encode::<RGBA32Float>(image, &pixel_by_pixel(planes), to)
        }
        (Samples::F32(planes), _) => encode::<Gray32Float>(image, &pixel_by_pixel(planes), to),
    };
    written.map_err(|error| {
        let TiffError::IoError(error) = error else { return io::Error::other(error) };
        error
    })
}

/// Values of planes, interleaved by pixel.
fn pixel_by_pixel(planes: &Planes) -> Vec<f32> {
    let channels = planes.channels();
    (0..planes.width() * planes.height()).flat_map(|i| channels.iter().map(move |c| c.data[i])).collect()
}

fn encode<C: ColorType>(image: &FileImage<'_>, values: &[C::Inner], to: &mut dyn Sink) -> TiffResult<()>
where
    [C::Inner]: TiffValue,
{
    let [width, height] = image.sides()?;
    let mut file = TiffEncoder::new(to)?;
    let mut encoder = file.new_image::<C>(width, height)?;
    if image.description.is_some() && image.channels > 1 {
        // Viewers would take three channels for colours.
        encoder.extra_samples(&vec![ExtraSamples::Unspecified; image.channels - 1])?;
    }
    if let Some([x, y]) = image.not_square() {
        encoder.resolution_unit(ResolutionUnit::None);
        encoder.x_resolution(Rational { n: x, d: 1_000_000 });
        encoder.y_resolution(Rational { n: y, d: 1_000_000 });
    }
    if let Some(profile) = &image.colours.profile {
        encoder.encoder().write_tag(Tag::IccProfile, &profile[..])?;
    }
    if let Some(description) = &image.description {
        encoder.encoder().write_tag(Tag::ImageDescription, &description[..])?;
    }
    encoder.write_data(values)
}
