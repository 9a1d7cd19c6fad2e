//! Images from files and from memory, as [`Bitmap`]s.

use std::path::Path;

use image::DynamicImage;

use super::decoded::decode;
use super::linear::{LinearImage, decode_linear, in_image};
use photosite_core::Invalid;
use photosite_core::input;
use photosite_transport::texture::{Bitmap, Texels};

/// Reads an image file.
pub fn read_bitmap(path: &Path) -> Result<Bitmap, Invalid> {
    let bytes = input::read(path).map_err(|source| {
        Invalid::new("", format!("cannot read {}: {source}", path.display()))
            .help("put the image there, or correct its name")
    })?;
    decode_bitmap(&bytes, path.display().to_string())
}

/// Decodes a PNG, JPEG, WebP, TIFF, PNM, OpenEXR or Radiance HDR image, whose kind is found from the bytes. Integer
/// images keep their encoding: whether a texture is sRGB-encoded is known where it is used. `name` is for messages.
pub(crate) fn decode_bitmap(bytes: &[u8], name: String) -> Result<Bitmap, Invalid> {
    if let Some(light) = decode_linear(bytes) {
        let of_file = |invalid| in_image(invalid, &name);
        let (texels, [width, height]) = light.and_then(of_light).map_err(of_file)?;
        return Ok(Bitmap { name, width, height, texels });
    }
    let image = decode(bytes, &name)?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(Bitmap { name, width, height, texels: texels(image) })
}

/// Texels of linear light for a texture, which must be whole: omitted or filled-in parts are refused, as are negative
/// values.
fn of_light(light: LinearImage) -> Result<(Texels, [usize; 2]), Invalid> {
    let size = [light.planes.width(), light.planes.height()];
    let whole = "write R, G and B, or Y, of linear sRGB and nothing else; transparency needs a PNG image";
    if light.components == 0 {
        let message = format!("holds no image, but the planes {}", light.others().join(", "));
        return Err(Invalid::new("", message).help(whole));
    }
    if let Some(what) = light.warnings.first().cloned().or(light.left_out()) {
        return Err(Invalid::new("", format!("cannot be a texture as a whole: {what}")).help(whole));
    }
    match light.into_texels()? {
        (texels, None) => Ok((Texels::Rgb32F(texels), size)),
        (_, Some(what)) => Err(Invalid::new("", what).help("convert the image to the colours of sRGB first")),
    }
}

fn texels(image: DynamicImage) -> Texels {
    use image::ColorType;
    match image.color() {
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            Texels::Rgba16(pixels(image.into_rgba16().into_raw()))
        }
        ColorType::Rgb32F | ColorType::Rgba32F => Texels::Rgb32F(pixels(image.into_rgb32f().into_raw())),
        // The crate may add types; it converts them.
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 | _ => {
            Texels::Rgba8(pixels(image.into_rgba8().into_raw()))
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
    use crate::exr::made_for_tests::{Part, file, floats};
    use image::{ImageBuffer, ImageFormat};

    fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).expect("encoded");
        bytes.into_inner()
    }

    #[test]
    fn eight_and_sixteen_bits_are_kept_and_grey_becomes_rgb() {
        let grey = DynamicImage::ImageLuma8(ImageBuffer::from_raw(2, 1, vec![3, 200]).expect("two pixels"));
        let bitmap = decode_bitmap(&encoded(&grey, ImageFormat::Png), "grey".into()).expect("decoded");
        assert!(matches!(&bitmap.texels, Texels::Rgba8(t) if t[..] == [[3, 3, 3, 255], [200, 200, 200, 255]]));
        let deep = DynamicImage::ImageRgb16(ImageBuffer::from_raw(1, 1, vec![1, 256, 65535]).expect("one pixel"));
        let bitmap = decode_bitmap(&encoded(&deep, ImageFormat::Png), "deep".into()).expect("decoded");
        assert!(matches!(&bitmap.texels, Texels::Rgba16(t) if t[..] == [[1, 256, 65535, 65535]]));
    }

    /// Textures of EXR files are linear light by the header, or refused.
    #[test]
    fn exr_images_are_linear_textures_as_a_whole() {
        let row = || Part::row(&[("B", &[0.25, 0.2]), ("G", &[0.5, 0.2]), ("R", &[1.0, 0.2])]);
        let decoded = |part: Part| decode_bitmap(&file(&[part]), "wood.exr".into());
        let bitmap = decoded(row()).expect("decoded");
        assert!(matches!(&bitmap.texels, Texels::Rgb32F(t) if t[..] == [[1.0, 0.5, 0.25], [0.2; 3]]));
        // The white of ACES is that of sRGB here.
        let aces = floats(&[0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.321_68, 0.337_67]);
        let bitmap = decoded(Part::row(&[("B", &[0.5]), ("G", &[0.5]), ("R", &[0.5])]).with(
            "chromaticities",
            "chromaticities",
            aces,
        ));
        let Texels::Rgb32F(texels) = bitmap.expect("decoded").texels else { panic!("linear light") };
        assert!(texels[0].iter().all(|value| (value - 0.5).abs() < 1e-4), "{texels:?}");
        for (part, words) in [
            (Part { display: [-1, 0, 2, 0], ..row() }, "its data window holds 2 of the 4 pixels"),
            (Part::row(&[("A", &[0.5]), ("B", &[0.5]), ("G", &[0.5]), ("R", &[0.5])]), "of its planes, A have no part"),
            (Part::row(&[("Z", &[1.0])]), "holds no image, but the planes Z"),
            (Part::row(&[("Y", &[f32::NAN])]), "1 number is not finite"),
            (Part::row(&[("Y", &[-0.5])]), "1 value is negative"),
        ] {
            let error = decoded(part).expect_err("refused");
            assert!(error.message.starts_with("wood.exr: ") && error.message.contains(words), "{error}");
            assert!(error.help.is_some(), "{error}");
        }
    }

    #[test]
    fn every_truncation_of_an_image_is_an_error_and_no_panic() {
        let image = DynamicImage::ImageRgb8(ImageBuffer::from_fn(5, 3, |x, y| image::Rgb([x as u8, y as u8, 9])));
        let bytes = encoded(&image, ImageFormat::Png);
        // The last 12 bytes are the end marker, which decoders may do without.
        for len in 0..bytes.len() - 12 {
            let error = decode_bitmap(&bytes[..len], "torn.png".into()).expect_err("truncated");
            assert!(error.message.contains("torn.png"));
        }
        let bytes = encoded(&image, ImageFormat::Jpeg);
        for len in 0..bytes.len() {
            // Some decoders fill what is missing with grey: no promise but not to panic.
            let _ = decode_bitmap(&bytes[..len], "torn.jpg".into());
        }
    }
}
