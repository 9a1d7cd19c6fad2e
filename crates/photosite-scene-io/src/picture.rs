//! Pictures from files and from memory, as [`Bitmap`]s.

use std::io::{Cursor, ErrorKind};
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use photosite_core::Invalid;
use photosite_core::{input, memory};
use photosite_transport::texture::{Bitmap, Texels};

/// Largest picture, pixels along a side.
pub(crate) const MAX_SIDE: u32 = 32_768;
/// Most memory that decoding a picture may take, bytes.
const MAX_BYTES: u64 = 4 << 30;
/// Most memory for what comes with its pixels: compressed profiles and texts, which may inflate a thousandfold. What is
/// larger is left out, as nothing of a texture depends on it.
const MAX_BESIDE: u64 = 16 << 20;
/// Kinds of files whose pixels take no more than [`MOST_INFLATION`] times as much memory as the file: those that are
/// packed by zlib at best, from bits or palettes.
const BOUNDED: [ImageFormat; 4] = [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Hdr, ImageFormat::Pnm];
const MOST_INFLATION: u64 = 1 << 15;

/// Reads a picture file.
pub fn read_picture(path: &Path) -> Result<Bitmap, Invalid> {
    let bytes = input::read(path).map_err(|source| {
        Invalid::new("", format!("cannot read {}: {source}", path.display()))
            .help("put the picture there, or correct its name")
    })?;
    decode_picture(&bytes, path.display().to_string())
}

/// Decodes a PNG, JPEG, WebP, TIFF, PNM or Radiance HDR picture, whichever the bytes say it is. Integer pictures keep
/// their encoding: whether a texture is sRGB-encoded is known where it is used. `name` is for messages.
pub(crate) fn decode_picture(bytes: &[u8], name: String) -> Result<Bitmap, Invalid> {
    let picture = decode(bytes, &name)?;
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    Ok(Bitmap { name, width, height, texels: texels(picture) })
}

/// The same, in whatever form the file has it.
pub fn decode(bytes: &[u8], name: &str) -> Result<DynamicImage, Invalid> {
    let bad = |problem: &str| {
        Invalid::new("", format!("cannot decode {name}: {problem}"))
            .help("the picture is damaged, or not one of PNG, JPEG and WebP; export it again as one of them")
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
        "make the picture smaller",
    )?;
    decoder.set_limits(limits(MAX_BYTES)).map_err(bad_image)?;
    if decoded > MAX_BYTES {
        return Err(bad("it is too large to be decoded"));
    }
    DynamicImage::from_decoder(decoder).map_err(bad_image)
}

/// Columns and rows of a picture, which is not decoded.
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

fn texels(picture: DynamicImage) -> Texels {
    use image::ColorType;
    match picture.color() {
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            Texels::Rgba16(pixels(picture.into_rgba16().into_raw()))
        }
        ColorType::Rgb32F | ColorType::Rgba32F => Texels::Rgb32F(pixels(picture.into_rgb32f().into_raw())),
        // The crate may add types; it converts them.
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 | _ => {
            Texels::Rgba8(pixels(picture.into_rgba8().into_raw()))
        }
    }
}

fn pixels<T: Copy, const N: usize>(components: Vec<T>) -> Vec<[T; N]> {
    components.as_chunks::<N>().0.to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::ImageBuffer;

    fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).expect("encoded");
        bytes.into_inner()
    }

    #[test]
    fn eight_and_sixteen_bits_are_kept_and_grey_becomes_rgb() {
        let grey = DynamicImage::ImageLuma8(ImageBuffer::from_raw(2, 1, vec![3, 200]).expect("two pixels"));
        let bitmap = decode_picture(&encoded(&grey, ImageFormat::Png), "grey".into()).expect("decoded");
        assert!(matches!(&bitmap.texels, Texels::Rgba8(t) if t[..] == [[3, 3, 3, 255], [200, 200, 200, 255]]));
        let deep = DynamicImage::ImageRgb16(ImageBuffer::from_raw(1, 1, vec![1, 256, 65535]).expect("one pixel"));
        let bitmap = decode_picture(&encoded(&deep, ImageFormat::Png), "deep".into()).expect("decoded");
        assert!(matches!(&bitmap.texels, Texels::Rgba16(t) if t[..] == [[1, 256, 65535, 65535]]));
    }

    #[test]
    fn every_truncation_of_a_picture_is_an_error_and_no_panic() {
        let picture = DynamicImage::ImageRgb8(ImageBuffer::from_fn(5, 3, |x, y| image::Rgb([x as u8, y as u8, 9])));
        let bytes = encoded(&picture, ImageFormat::Png);
        // The last 12 bytes are the end marker, which decoders may do without.
        for len in 0..bytes.len() - 12 {
            let error = decode_picture(&bytes[..len], "torn.png".into()).expect_err("truncated");
            assert!(error.message.contains("torn.png"));
        }
        let bytes = encoded(&picture, ImageFormat::Jpeg);
        for len in 0..bytes.len() {
            // Some decoders fill what is missing with grey: no promise but not to panic.
            let _ = decode_picture(&bytes[..len], "torn.jpg".into());
        }
    }
}
