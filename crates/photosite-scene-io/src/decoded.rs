//! Decoding of PNG, JPEG, WebP, TIFF, PNM and Radiance HDR files by the `image` library, within limits.

use std::io::{Cursor, ErrorKind};

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use photosite_core::{Invalid, memory};

/// Largest image, pixels along a side.
pub(crate) const MAX_SIDE: u32 = 32_768;
/// Largest memory for decoding an image, bytes.
const MAX_BYTES: u64 = 4 << 30;
/// Largest memory for metadata, bytes: compressed profiles and texts may inflate a thousandfold. Larger metadata are
/// skipped, as no texture depends on them.
const MAX_BESIDE: u64 = 16 << 20;
/// Kinds of files whose pixels take no more than [`MOST_INFLATION`] times as much memory as the file: they are
/// compressed by zlib at best, from bits or palettes.
const BOUNDED: [ImageFormat; 4] = [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Hdr, ImageFormat::Pnm];
const MOST_INFLATION: u64 = 1 << 15;

/// Decodes an image in the pixel type of the file, whose kind is found from the bytes; `name` is for messages.
pub fn decode(bytes: &[u8], name: &str) -> Result<DynamicImage, Invalid> {
    let bad = |problem: &str| {
        Invalid::new("", format!("cannot decode {name}: {problem}"))
            .help("the image is damaged, or not one of PNG, JPEG and WebP; export it again as one of them")
    };
    let bad_image = |e: ImageError| {
        let is_cut = matches!(&e, ImageError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof);
        if is_cut { bad("the file ends too early") } else { bad(&e.to_string()) }
    };
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| bad(&e.to_string()))?;
    reader.limits(limits(MAX_BESIDE));
    let is_bounded = reader.format().is_some_and(|format| BOUNDED.contains(&format));
    let mut decoder = reader.into_decoder().map_err(bad_image)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(bad("it has no pixels"));
    }
    // Sizes are looked at before memory is taken for them.
    let decoded = decoder.total_bytes();
    if is_bounded && decoded > (bytes.len() as u64).saturating_mul(MOST_INFLATION) {
        return Err(bad(&format!("its {} bytes cannot hold {width} × {height} pixels", bytes.len())));
    }
    // Decoded, and in the form that it is kept in: twice while it changes its form.
    let of_pixel = u64::from(decoder.color_type().bytes_per_pixel()).max(4);
    memory::check(
        (u64::from(width) * u64::from(height)).saturating_mul(2 * of_pixel),
        &format!("decoding the {width} × {height} pixels of {name}"),
        "make the image smaller",
    )?;
    decoder.set_limits(limits(MAX_BYTES)).map_err(bad_image)?;
    if decoded > MAX_BYTES {
        return Err(bad("it is too large to be decoded"));
    }
    DynamicImage::from_decoder(decoder).map_err(bad_image)
}

/// Columns and rows of an image, from its header alone.
pub fn dimensions(bytes: &[u8]) -> Result<[u32; 2], ImageError> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    reader.limits(limits(MAX_BESIDE));
    reader.into_dimensions().map(|(width, height)| [width, height])
}

fn limits(most: u64) -> image::Limits {
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(most);
    limits
}
