//! Pictures from files and from memory, as [`Bitmap`]s.

use std::path::Path;

use image::DynamicImage;

use super::decoded::decode;
use super::linear::{decode_radiance, in_picture, is_radiance};
use photosite_core::Invalid;
use photosite_core::input;
use photosite_transport::texture::{Bitmap, Texels};

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
    if is_radiance(bytes) {
        return of_radiance(bytes, name);
    }
    let picture = decode(bytes, &name)?;
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    Ok(Bitmap { name, width, height, texels: texels(picture) })
}

/// The texels of a Radiance HDR picture.
fn of_radiance(bytes: &[u8], name: String) -> Result<Bitmap, Invalid> {
    let of_file = |invalid| in_picture(invalid, &name);
    let light = decode_radiance(bytes).map_err(of_file)?;
    let [width, height] = [light.planes.width(), light.planes.height()];
    let (texels, negative) = light.into_texels().map_err(of_file)?;
    match negative {
        None => Ok(Bitmap { name, width, height, texels: Texels::Rgb32F(texels) }),
        Some(what) => Err(of_file(Invalid::new("", what).help("convert the picture to the colours of sRGB first"))),
    }
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
    use std::io::Cursor;

    use super::*;
    use image::{ImageBuffer, ImageFormat};

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
