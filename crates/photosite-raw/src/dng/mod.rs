//! DNG files: the image with everything that a raw developer wants to know, after the Digital Negative specification
//! ([Dng16](photosite_core::references#dng16)), which the names of the tags come from.
//!
//! In: a [`RawImage`]. Out: a file of four directories, as the specification recommends: a thumbnail that any TIFF
//! reader shows, which also carries what holds for the whole image; beneath it the raw image and a larger image
//! for viewers, as JPEG; and EXIF. No date is written, so that the same image gives the same bytes.
//!
//! | layout | is written as |
//! |---|---|
//! | mosaics of R, G, B, C, M, Y, W | a colour filter array; clear filters are called white |
//! | monochrome, `full:RGB` | LinearRaw of 1 or 3 numbers a pixel |
//! | other channels | not at all: [`dng_can_hold`] says why |

mod colour;
mod filters;
mod ifd;
mod numbers;
mod opcodes;
mod profile;
mod read;
mod read_pixel_values;
#[cfg(test)]
mod tests;
mod whole;
mod xmp;

use std::io::{self, Seek, Write};

use tiff::TiffResult;
use tiff::encoder::{Rational, TiffEncoder};
use tiff::tags::Tag;

use super::rational::{rational, srational};
use super::tiff::io_error;
use super::{Cfa, Distortion, PixelArea, RawImage, Warp, tag, thumbnail};
use photosite_core::Invalid;

use ifd::{Ifd, pad, write_text, write_undefined};
pub use numbers::DngCompression;
pub use profile::read_profile;
pub use read::{read_dng, read_dng_or_tiff};

/// Checks that a DNG file can describe this layout.
pub fn dng_can_hold(cfa: &Cfa) -> Result<(), Invalid> {
    filters::codes(cfa).map(|_| ())
}

/// Writes an uncompressed DNG file. The image must have pixels, and fewer than a TIFF file can hold (4 GiB).
pub fn write_dng<W: Write + Seek>(raw: &RawImage, to: W) -> io::Result<()> {
    write_compressed_dng(raw, DngCompression::None, to)
}

/// Writes a DNG file whose pixel values are compressed.
pub fn write_compressed_dng<W: Write + Seek>(raw: &RawImage, compression: DngCompression, to: W) -> io::Result<()> {
    if raw.data.is_empty() {
        return Err(io::Error::other("the image has no pixels"));
    }
    raw.validate().map_err(io::Error::other)?;
    // Floating-point numbers have no tables.
    let raw = if compression == DngCompression::Deflate { &*raw.linear() } else { raw };
    let codes = filters::codes(&raw.cfa).map_err(io::Error::other)?;
    write_directories(raw, &codes, compression, to).map_err(io_error)
}

fn write_directories<W: Write + Seek>(
    raw: &RawImage,
    codes: &[u8],
    compression: DngCompression,
    to: W,
) -> TiffResult<()> {
    let mut file = TiffEncoder::new(to)?;
    let mut ifd = file.extra_directory()?;
    numbers::write(raw, compression, &mut ifd)?;
    write_layout(raw, codes, &mut ifd)?;
    write_levels(raw, &mut ifd)?;
    write_lens(raw, &mut ifd)?;
    let image = ifd.finish_with_offsets()?;
    let mut preview = file.extra_directory()?;
    let shown = raw.linear().cropped();
    numbers::write_preview(&thumbnail::thumbnail(&shown, PREVIEW_SIDE), &mut preview)?;
    let preview = preview.finish_with_offsets()?;
    let mut exif = file.extra_directory()?;
    write_exif(raw, &mut exif)?;
    let exif = exif.finish_with_offsets()?;
    let mut main = file.image_directory()?;
    main.write_tag(Tag::SubIfd, &[image.offset, preview.offset][..])?;
    main.write_tag(Tag::ExifDirectory, exif.offset)?;
    numbers::write_thumbnail(&thumbnail::thumbnail(&shown, THUMBNAIL_SIDE), &mut main)?;
    write_main(raw, compression, &mut main)?;
    main.finish()
}

/// Longer side of the image that file browsers show, pixels.
const THUMBNAIL_SIDE: usize = 256;
/// Longer side of the image that viewers show, pixels.
const PREVIEW_SIDE: usize = 1024;

/// Writes the tags that hold for the file as a whole.
fn write_main<W: Write + Seek>(raw: &RawImage, compression: DngCompression, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let metadata = &raw.metadata;
    ifd.write_tag(Tag::NewSubfileType, tag::REDUCED)?;
    ifd.write_tag(Tag::XResolution, Rational { n: 72, d: 1 })?;
    ifd.write_tag(Tag::YResolution, Rational { n: 72, d: 1 })?;
    ifd.write_tag(Tag::ResolutionUnit, tiff::tags::ResolutionUnit::Inch.to_u16())?;
    write_text(ifd, Tag::Make, "photosite")?;
    write_text(ifd, Tag::Model, &metadata.camera_model)?;
    write_text(ifd, Tag::Software, concat!("photosite ", env!("CARGO_PKG_VERSION")))?;
    ifd.write_tag(Tag::Orientation, u16::from(metadata.orientation.number()))?;
    // What a reader must know at least: floating-point numbers came with 1.4.
    let needed = if compression == DngCompression::Deflate { 4 } else { 1 };
    ifd.write_tag(tag::DNG_VERSION, &[1u8, 7, 0, 0][..])?;
    ifd.write_tag(tag::DNG_BACKWARD_VERSION, &[1u8, needed, 0, 0][..])?;
    write_text(ifd, tag::UNIQUE_CAMERA_MODEL, &format!("photosite {}", metadata.camera_model))?;
    if !metadata.camera_serial.is_empty() {
        write_text(ifd, tag::CAMERA_SERIAL_NUMBER, &metadata.camera_serial)?;
    }
    ifd.write_tag(tag::BASELINE_EXPOSURE, srational(metadata.baseline_exposure_ev))?;
    let PixelArea { width, height, .. } = raw.active();
    let packet = xmp::packet(metadata, [width, height]);
    ifd.write_tag(tag::XMP, packet.as_bytes())?;
    pad(ifd, packet.len())?;
    colour::write(metadata, ifd)
}

/// Writes the layout: the places of the values and the channels that they belong to.
fn write_layout<W: Write + Seek>(raw: &RawImage, codes: &[u8], ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let PixelArea { x, y, width, height } = raw.active();
    ifd.write_tag(Tag::NewSubfileType, 0u32)?;
    let is_mosaic = !raw.cfa.is_mono() && !raw.cfa.is_full();
    if is_mosaic {
        let cfa = raw.cfa.from(x, y);
        let (columns, rows) = cfa.tile_size();
        let pattern: Vec<u8> = (0..columns * rows).map(|i| codes[cfa.channel_at(i % columns, i / columns)]).collect();
        ifd.write_tag(tag::CFA_REPEAT_PATTERN_DIM, &[u16::try_from(rows)?, u16::try_from(columns)?][..])?;
        ifd.write_tag(tag::CFA_PATTERN, &pattern[..])?;
        pad(ifd, pattern.len())?;
        ifd.write_tag(tag::CFA_PLANE_COLOR, codes)?;
        pad(ifd, codes.len())?;
    }
    if is_mosaic || raw.metadata.is_staggered {
        // The tag belongs to mosaics; in monochrome files it stands for us.
        let layout = if raw.metadata.is_staggered { tag::EVEN_ROWS_TO_THE_RIGHT } else { tag::RECTANGULAR };
        ifd.write_tag(tag::CFA_LAYOUT, layout)?;
    }
    // The longer side of a pixel is stretched.
    let aspect = raw.metadata.pixel_aspect();
    ifd.write_tag(tag::DEFAULT_SCALE, &[aspect.max(1.0), (1.0 / aspect).max(1.0)].map(rational)[..])?;
    let shown = raw.metadata.default_crop.unwrap_or(PixelArea { x: 0, y: 0, width, height });
    ifd.write_tag(tag::DEFAULT_CROP_ORIGIN, &[u32::try_from(shown.x)?, u32::try_from(shown.y)?][..])?;
    ifd.write_tag(tag::DEFAULT_CROP_SIZE, &[u32::try_from(shown.width)?, u32::try_from(shown.height)?][..])?;
    let rectangle = |left: usize, top: usize, right: usize, bottom: usize| -> TiffResult<[u32; 4]> {
        Ok([u32::try_from(top)?, u32::try_from(left)?, u32::try_from(bottom)?, u32::try_from(right)?])
    };
    ifd.write_tag(tag::ACTIVE_AREA, &rectangle(x, y, x + width, y + height)?[..])?;
    let masked = [
        rectangle(0, 0, raw.width, y)?,
        rectangle(0, y + height, raw.width, raw.height)?,
        rectangle(0, y, x, y + height)?,
        rectangle(x + width, y, raw.width, y + height)?,
    ];
    let masked: Vec<[u32; 4]> =
        masked.into_iter().filter(|[top, left, bottom, right]| top < bottom && left < right).collect();
    if masked.is_empty() { Ok(()) } else { ifd.write_tag(tag::MASKED_AREAS, masked.as_flattened()) }
}

/// Black, white and noise.
fn write_levels<W: Write + Seek>(raw: &RawImage, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let PixelArea { x, y, width, height } = raw.active();
    let samples = raw.cfa.samples_per_pixel();
    let black = raw.black_level_dn.from(&raw.cfa, x, y);
    let ((tile_width, rows), tile) = black.tile();
    // The tag has a level for each number of a pixel, so its tile is one of whole pixels.
    let columns = if tile_width.is_multiple_of(samples) { tile_width / samples } else { tile_width };
    let levels: Vec<f32> = (0..rows * columns * samples)
        .map(|i| tile[i / (columns * samples) * tile_width + i % (columns * samples) % tile_width])
        .collect();
    ifd.write_tag(tag::BLACK_LEVEL_REPEAT_DIM, &[u16::try_from(rows)?, u16::try_from(columns)?][..])?;
    if levels.iter().all(|level| level.fract() == 0.0) {
        ifd.write_tag(tag::BLACK_LEVEL, &levels.iter().map(|&level| level as u16).collect::<Vec<_>>()[..])?;
    } else {
        ifd.write_tag(tag::BLACK_LEVEL, &levels.iter().map(|&level| rational(level.into())).collect::<Vec<_>>()[..])?;
    }
    for (tag, deltas, side) in [
        (tag::BLACK_LEVEL_DELTA_H, black.column_deltas(), width),
        (tag::BLACK_LEVEL_DELTA_V, black.row_deltas(), height),
    ] {
        if !deltas.is_empty() {
            let delta = |i: usize| srational(deltas.get(i).copied().unwrap_or(0.0).into());
            ifd.write_tag(tag, &(0..side).map(delta).collect::<Vec<_>>()[..])?;
        }
    }
    if let Some(table) = &raw.linearisation {
        ifd.write_tag(tag::LINEARIZATION_TABLE, &table[..])?;
    }
    let whites: Vec<u32> = (0..samples).map(|channel| raw.white_of(channel).into()).collect();
    ifd.write_tag(tag::WHITE_LEVEL, &whites[..])?;
    let noise = &raw.metadata.noise_profile;
    if noise.is_empty() { Ok(()) } else { ifd.write_tag(tag::NOISE_PROFILE, noise.as_flattened()) }
}

/// Writes the corrections of the lens that a developer can make.
fn write_lens<W: Write + Seek>(raw: &RawImage, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let PixelArea { width, height, .. } = raw.active();
    let warp = match raw.metadata.distortion {
        Some(Distortion::Lens(lens)) => Warp::of_lens(&lens, [width, height], raw.metadata.pixel_aspect()),
        Some(Distortion::Warp(warp)) => Some(warp),
        None => None,
    };
    // darktable takes a map for each place of a Bayer tile only.
    let tile = if raw.cfa.is_bayer() { [2, 2] } else { [1, 1] };
    let [first, second, third] = &raw.metadata.opcodes;
    for (tag, opcodes, warp, tile) in [
        (tag::OPCODE_LIST_1, first, None, [1, 1]),
        (tag::OPCODE_LIST_2, second, None, tile),
        (tag::OPCODE_LIST_3, third, warp.as_ref(), [1, 1]),
    ] {
        if !opcodes.is_empty() || warp.is_some() {
            write_undefined(ifd, tag, &opcodes::list_of(opcodes, warp, [width, height], tile))?;
        }
    }
    Ok(())
}

fn write_exif<W: Write + Seek>(raw: &RawImage, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let metadata = &raw.metadata;
    write_undefined(ifd, tag::EXIF_VERSION, b"0230")?;
    ifd.write_tag(tag::EXPOSURE_TIME, rational(metadata.exposure_time_s))?;
    if let Some(f_number) = metadata.f_number {
        ifd.write_tag(tag::F_NUMBER, rational(f_number))?;
    }
    if let Some(iso) = metadata.iso {
        ifd.write_tag(tag::PHOTOGRAPHIC_SENSITIVITY, u16::try_from(iso).unwrap_or(u16::MAX))?;
        ifd.write_tag(tag::SENSITIVITY_TYPE, tag::IS_ISO_SPEED)?;
        ifd.write_tag(tag::ISO_SPEED, iso)?;
    }
    if let Some(focal_length_m) = metadata.focal_length_m {
        ifd.write_tag(tag::FOCAL_LENGTH, rational(focal_length_m * 1e3))?;
    }
    if let Some([x, y]) = metadata.pixel_pitch_m {
        ifd.write_tag(tag::FOCAL_PLANE_X_RESOLUTION, rational(0.01 / x))?;
        ifd.write_tag(tag::FOCAL_PLANE_Y_RESOLUTION, rational(0.01 / y))?;
        ifd.write_tag(tag::FOCAL_PLANE_RESOLUTION_UNIT, tag::PER_CENTIMETRE)?;
    }
    if !metadata.camera_serial.is_empty() {
        write_text(ifd, tag::BODY_SERIAL_NUMBER, &metadata.camera_serial)?;
    }
    Ok(())
}
