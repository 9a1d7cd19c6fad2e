//! Environment maps: [linear light](super::linear) from all directions.

use std::path::Path;

use super::envmap::{of_cube, of_latitude_longitude};
use super::linear::{LinearImage, Mapping, decode_linear, in_image};
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, input};
use photosite_transport::texture::{Bitmap, Texels};

/// Largest environment map: 16384 × 8192 texels take 1.6 GB.
const MAX_TEXELS: usize = 1 << 27;

/// An environment map as read from a file.
#[derive(Clone, Debug)]
pub struct EnvironmentFile {
    /// Texels: longitude from left to right, latitude from top to bottom.
    pub bitmap: Bitmap,
    /// Luminance of a value of 1 as stated by the file, cd/m².
    pub white_luminance_nit: Option<f64>,
}

/// Reads an environment map, as [`decode_environment`] does.
pub fn read_environment(path: &Path, warnings: &mut Warnings) -> Result<EnvironmentFile, Invalid> {
    let name = path.display().to_string();
    let bytes = input::read(path).map_err(|source| {
        Invalid::new("", format!("cannot read {name}: {source}"))
            .help("paths are relative to the file that contains them")
    })?;
    decode_environment(&bytes, name, warnings)
}

/// Decodes an environment map; `name` is for messages. Texels that are not finite are refused; negative ones, which the
/// filters of editing programs leave behind and which colours outside sRGB have, become zero with a warning.
pub fn decode_environment(bytes: &[u8], name: String, warnings: &mut Warnings) -> Result<EnvironmentFile, Invalid> {
    let read = decode_linear(bytes).unwrap_or_else(|| {
        let line = bytes.split(|byte| b"\r\n".contains(byte)).next().unwrap_or_default();
        let line = String::from_utf8_lossy(line.get(..16).unwrap_or(line)).into_owned();
        let begins = match line.as_str() {
            "" if bytes.is_empty() => "it is empty".to_owned(),
            text if !text.is_empty() && text.chars().all(|c| !c.is_control() && c != char::REPLACEMENT_CHARACTER) => {
                format!("it begins with {text:?}")
            }
            _ => "it begins with bytes of another kind".to_owned(),
        };
        let message = format!("is neither Radiance HDR, which begins with #?RADIANCE, nor OpenEXR: {begins}");
        Err(Invalid::new("", message).help("images of 8 or 16 bits hold no sun; use a .hdr or .exr image"))
    });
    let of_file = |invalid| in_image(invalid, &name);
    let light = read.map_err(of_file)?;
    check(&light).map_err(of_file)?;
    let said = said(&light);
    let white_luminance_nit = light.white_luminance_nit;
    let size = [light.planes.width(), light.planes.height()];
    let mapping = light.mapping.clone();
    let (texels, negative) = light.into_texels().map_err(of_file)?;
    let (texels, [width, height]) = match mapping {
        Mapping::LatitudeLongitude => of_latitude_longitude(&texels, size),
        Mapping::Cube => of_cube(&texels, size).map_err(of_file)?,
        Mapping::Unstated | Mapping::View(_) => (texels, size),
    };
    let negative = negative.map(|what| format!("{what}: they are taken to be 0"));
    said.into_iter().chain(negative).for_each(|message| warnings.once(format!("{name}: {message}")));
    let bitmap = Bitmap { name, width, height, texels: Texels::Rgb32F(texels) };
    Ok(EnvironmentFile { bitmap, white_luminance_nit })
}

/// Refuses images that do not cover all directions.
fn check(light: &LinearImage) -> Result<(), Invalid> {
    if light.components == 0 {
        let message = format!("holds no image, but the planes {}", light.others().join(", "));
        return Err(Invalid::new("", message).help("give an image with the channels R, G and B, or one layer of them"));
    }
    if light.planes.width() * light.planes.height() > MAX_TEXELS {
        return Err(Invalid::new("", format!("has more than {MAX_TEXELS} pixels")).help("make the image smaller"));
    }
    Ok(())
}

/// Warnings of an image that is taken for all directions.
fn said(light: &LinearImage) -> Vec<String> {
    let mut said = light.warnings.clone();
    said.extend(light.left_out());
    if let Mapping::View(view) = &light.mapping {
        said.push(format!(
            "its VIEW, {view:?}, is a camera's: its columns are taken for longitudes, its rows for latitudes"
        ));
    }
    if light.pixel_aspect != 1.0 {
        said.push("the shape of pixels that it states is left out, as they cover all directions".to_owned());
    }
    said
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::exr::made_for_tests::{Part, file, floats};

    const SKY: [[f32; 3]; 2] = [[0.25, 1.0, 2000.0], [0.5, 0.125, 0.0]];

    fn write_exr(path: &Path, texels: [[f32; 3]; 2]) {
        exr::prelude::write_rgb_file(path, 2, 1, |x, _| texels[x].into()).expect("written");
    }

    fn texels(image: &Bitmap) -> &[[f32; 3]] {
        match &image.texels {
            Texels::Rgb32F(texels) => texels,
            Texels::Rgba8(_) | Texels::Rgba16(_) => panic!("{:?}", image.texels),
        }
    }

    #[test]
    fn exr_and_hdr_images_are_read_in_linear_rgb() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let exr = folder.path().join("sky.exr");
        write_exr(&exr, SKY);
        let mut warnings = Warnings::default();
        let image = read_environment(&exr, &mut warnings).expect("valid").bitmap;
        assert_eq!((image.width, image.height, texels(&image)), (2, 1, &SKY[..]));

        let hdr = folder.path().join("sky.hdr");
        let pixels = image::Rgb32FImage::from_fn(2, 1, |x, _| image::Rgb(SKY[x as usize]));
        pixels.save(&hdr).expect("written");
        let image = read_environment(&hdr, &mut warnings).expect("valid").bitmap;
        for (read, written) in texels(&image).iter().zip(&SKY) {
            // RGBE has 8 bits of mantissa, scaled by the largest component.
            let tolerance = written.iter().fold(0.0f32, |m, c| m.max(*c)) / 128.0;
            assert!(read.iter().zip(written).all(|(r, w)| (r - w).abs() <= tolerance), "{read:?} {written:?}");
        }
        assert!(warnings.into_messages().is_empty());
    }

    #[test]
    fn what_is_not_finite_is_refused_and_what_is_negative_reported() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("sky.exr");
        write_exr(&path, [SKY[0], [1.0, f32::INFINITY, 1.0]]);
        let error = read_environment(&path, &mut Warnings::default()).expect_err("infinite");
        assert!(error.message.contains("column 1, row 0"), "{error}");
        write_exr(&path, [SKY[0], [1.0, -0.5, 1.0]]);
        let mut warnings = Warnings::default();
        let image = read_environment(&path, &mut warnings).expect("mended").bitmap;
        assert_eq!(texels(&image)[1], [1.0, 0.0, 1.0]);
        assert!(warnings.into_messages()[0].contains("1 value is negative"));
    }

    /// Texels and warnings of a file with a single part.
    fn by_hand(part: Part) -> Result<(Vec<[f32; 3]>, Vec<String>), Invalid> {
        let mut warnings = Warnings::default();
        let image = decode_environment(&file(&[part]), "sky.exr".to_owned(), &mut warnings)?.bitmap;
        Ok((texels(&image).to_vec(), warnings.into_messages()))
    }

    fn row() -> Part {
        Part::row(&[("B", &[0.25, 0.2]), ("G", &[0.5, 0.2]), ("R", &[1.0, 0.2])])
    }

    #[test]
    fn surroundings_are_what_their_header_says() {
        // ITU-R BT.2087, annex 1: BT.2020 to BT.709.
        let rec2020 = floats(&[0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329]);
        let (found, said) = by_hand(row().with("chromaticities", "chromaticities", rec2020)).expect("read");
        let expected = [1.6605 - 0.2938 - 0.0182, -0.1246 + 0.566_45 - 0.0021, -0.0182 - 0.0503 + 0.2797];
        assert!(found[0].iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?}");
        assert!(said.is_empty(), "{said:?}");
        // The second of four columns and the next are stored.
        let (found, said) = by_hand(Part { display: [-1, 0, 2, 0], ..row() }).expect("read");
        assert_eq!(found, [[0.0; 3], [1.0, 0.5, 0.25], [0.2; 3], [0.0; 3]]);
        assert!(said[0].starts_with("sky.exr: its data window holds 2 of the 4 pixels"), "{said:?}");
        let (found, _) = by_hand(Part::row(&[("Y", &[3.0])])).expect("grey");
        assert_eq!(found, [[3.0; 3]]);
    }

    #[test]
    fn what_is_no_image_of_all_directions_is_refused_or_said() {
        let error = by_hand(row().with("envmap", "envmap", vec![1])).expect_err("no cube");
        assert!(error.message.starts_with("sky.exr: envmap: ") && error.help.is_some(), "{error}");
        let error = by_hand(Part::row(&[("Z", &[1.0])])).expect_err("depth");
        assert!(error.message.contains("holds no image, but the planes Z"), "{error}");
        let (_, said) = by_hand(row().with("pixelAspectRatio", "float", floats(&[2.0]))).expect("read");
        assert!(said.len() == 1 && said[0].contains("shape of pixels"), "{said:?}");
        let view = b"#?RADIANCE\nVIEW=-vtv -vh 40\n\n-Y 1 +X 1\n\x80\x80\x80\x81";
        let mut warnings = Warnings::default();
        decode_environment(view, "sky.hdr".to_owned(), &mut warnings).expect("read");
        let said = warnings.into_messages();
        assert!(said.len() == 1 && said[0].contains("its VIEW, \"-vtv -vh 40\", is a camera's"), "{said:?}");
    }

    /// Panorama of a latitude-longitude map of three columns: its centres lie between them. A cube of uniform faces is
    /// uniform.
    #[test]
    fn environment_maps_of_openexr_become_panoramas() {
        let map = Part::row(&[("Y", &[1.0, 3.0, 5.0])]).with("envmap", "envmap", vec![0]);
        assert_eq!(by_hand(map).expect("read"), (vec![[2.0; 3], [4.0; 3]], Vec::new()));
        let column = Part { data: [0, 0, 0, 5], display: [0, 0, 0, 5], ..Part::row(&[("Y", &[2.0; 6])]) };
        let (texels, said) = by_hand(column.with("envmap", "envmap", vec![1])).expect("a cube of six texels");
        assert_eq!((texels, said), (vec![[2.0; 3]; 8], Vec::new()));
    }

    /// Overflow by an exposure: the largest number of a file, 255/256·2^127, leaves the range of f32 once it is divided
    /// by 1/8.
    #[test]
    fn numbers_that_an_exposure_takes_beyond_floats_are_named() {
        let file = b"#?RADIANCE\nEXPOSURE=0.125\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x80\xff\x80\xff";
        let error = decode_environment(file, "sky.hdr".to_owned(), &mut Warnings::default()).expect_err("refused");
        assert!(
            error.message.contains("sky.hdr: 3 numbers are not finite") && error.message.contains("column 1, row 0"),
            "{error}"
        );
    }

    #[test]
    fn torn_missing_and_unsuitable_images_are_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("sky.exr");
        write_exr(&path, SKY);
        let bytes = fs::read(&path).expect("there");
        for len in 0..bytes.len() {
            fs::write(&path, &bytes[..len]).expect("written");
            assert!(read_environment(&path, &mut Warnings::default()).is_err(), "{len} of {} bytes", bytes.len());
        }
        image::RgbImage::new(1, 1).save(folder.path().join("sky.png")).expect("written");
        for name in ["sky.png", "absent.hdr"] {
            let error = read_environment(&folder.path().join(name), &mut Warnings::default()).expect_err(name);
            assert!(error.message.contains(name), "{error}");
        }
    }
}
