//! Images to be compared, from files of any kind that photosite writes and similar ones of other programs.
//!
//! | file | channels | unit |
//! |---|---|---|
//! | EXR | as they are named; `variance.X` is the variance of `X`; of spectral images the bands, named by their wavelengths in nm, without the preview | attribute `unit` or `emissiveUnits` |
//! | Radiance HDR | `R`, `G`, `B` of linear sRGB | none |
//! | DNG, NPY of 16 bits, PBM, PGM, raw EXR, and TIFF and PNG of one plane of 16 bits | `raw`: a mosaic; `R`, `G`, `B` where every pixel has all of them | DN |
//! | other PNG and TIFF, JPEG, PPM, NPY of 8 bits | `Y`, `R`, `G`, `B`, alpha `A` | codes, as they are encoded |
//! | NPY and TIFF of floating-point numbers | the same | none |
//!
//! DNG and raw EXR files say which pixels see light: unless asked for, the masked ones are left out.

use std::io::BufReader;
use std::path::Path;

use super::formats::{Format, lists::endings};
use super::raw_file::read_any;
use photosite_core::input;
use photosite_core::{Error, Result};
use photosite_measure::validation::ComparedImage;
use photosite_raw::Pixels;

pub use super::formats::{ImageFile, interleaved};

impl ImageFile {
    /// Reads an image, in the format that the file's name says.
    pub fn read(path: &Path, pixels: Pixels) -> Result<Self> {
        let Some(format) = Format::of(path).filter(|format| format.reads_images()) else { return Err(no_image(path)?) };
        let name = path.display().to_string();
        let file = input::open(path).map_err(|source| Error::io(path, "read", source))?;
        let file = &mut BufReader::new(file);
        let read = match format.image_reader {
            Some(read) => read(file, name.clone(), pixels),
            None => read_any(file).map(|raw| Self::of_raw(name.clone(), raw.linear().into_owned(), pixels)),
        };
        let read = read.map_err(|invalid| invalid.in_file(path))?;
        Ok(Self { notes: read.notes.of_file(&name), ..read })
    }
}

/// Error of a file whose name is that of no image.
fn no_image(path: &Path) -> Result<Error> {
    if path.is_dir() {
        let example = path.join("image.png");
        return Ok(Error::Usage {
            message: format!("{} is a folder, and an image is expected here", path.display()),
            help: Some(format!("give an image in it, for example {}", example.display()).into()),
        });
    }
    input::metadata(path).map_err(|source| Error::io(path, "read", source))?;
    Ok(Error::Usage {
        message: format!("{} is not an image of a kind that photosite knows", path.display()),
        help: Some(format!("give a {} file", endings(Format::reads_images)).into()),
    })
}

/// Reads an image with its pixels as they lie in the file, in the format that the file's name says.
pub fn read_image_file(path: &Path, pixels: Pixels) -> Result<ComparedImage> {
    ImageFile::read(path, pixels).map(ImageFile::as_it_lies)
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use image::{DynamicImage, ImageBuffer, ImageFormat};
    use rstest::rstest;
    use tiff::encoder::{TiffEncoder, colortype};

    use super::*;
    use crate::electrons::write_electrons;
    use crate::exr::{Attribute, write_exr};
    use crate::formats::{FORMATS, PNG};
    use crate::spectral_exr::write_irradiance;
    use photosite_core::image::{Estimate, Planes};
    use photosite_core::units::Seconds;
    use photosite_raw::{Cfa, DngCompression, RawImage};

    /// Reads a file of that extension from memory.
    fn read(extension: &str, bytes: &[u8]) -> Result<ComparedImage> {
        let mut file = tempfile::Builder::new().suffix(&format!(".{extension}")).tempfile().expect("a temporary file");
        file.write_all(bytes).expect("written");
        read_image_file(file.path(), Pixels::Active)
    }

    fn channels(planes: &Planes) -> Vec<(&str, &[f32])> {
        planes.channels().iter().map(|c| (&c.name[..], &c.data[..])).collect()
    }

    #[test]
    fn electrons_come_with_their_variances() {
        let mean = Planes::zeros(2, 2, ["B", "G", "R"]);
        let mut variance = Planes::zeros(2, 2, ["B", "G", "R"]);
        variance.channels_mut()[2].data[3] = 0.25;
        let mut file = Vec::new();
        write_electrons(&Estimate { mean, variance: variance.clone() }, Seconds(1.0), Cursor::new(&mut file))
            .expect("written");
        let image = read("exr", &file).expect("read");
        assert_eq!(channels(&image.mean), ["R", "G", "B"].map(|name| (name, &[0.0; 4][..])));
        assert_eq!(image.variance, variance);
        assert_eq!(image.unit.as_deref(), Some("e-"));
    }

    #[test]
    fn a_variance_of_nothing_is_a_channel_like_any_other() {
        let mut file = Vec::new();
        let planes = Planes::zeros(1, 1, ["Y", "variance.X"]);
        write_exr(&planes, &[("unit", Attribute::Text("lux".to_owned()))], Cursor::new(&mut file)).expect("written");
        let image = read("exr", &file).expect("read");
        assert_eq!(image.mean, planes);
        assert!(image.variance.channels().is_empty());
    }

    #[test]
    fn spectral_images_leave_their_preview_behind() {
        let planes = Planes::zeros(2, 1, ["355", "1095"]);
        let mut file = Vec::new();
        write_irradiance(&planes, Cursor::new(&mut file)).expect("written");
        assert_eq!(read("exr", &file).expect("read").mean, planes);
    }

    #[test]
    fn every_raw_file_holds_the_same_mosaic() {
        let raw = RawImage {
            width: 4,
            height: 2,
            data: vec![0, 1, 255, 256, 4095, 64, 300, 65_535],
            cfa: Cfa::parse("GRBG").expect("known"),
            bits: 12,
            black_level_dn: 64.into(),
            white_level_dn: 4095,
            ..RawImage::default()
        };
        let data: Vec<f32> = raw.data.iter().map(|&dn| f32::from(dn)).collect();
        for format in FORMATS.into_iter().filter(|format| format.writes_raw() || *format == &PNG) {
            let mut file = Cursor::new(Vec::new());
            format.write_raw(&raw, DngCompression::None, &mut file).expect("written");
            let extension = format.ending();
            let image = read(extension, file.get_ref()).expect("read");
            assert_eq!(channels(&image.mean), [("raw", &data[..])], "{extension}");
            assert_eq!(image.unit.as_deref(), Some("DN"));
            assert_eq!(image.mosaic, (extension == "dng").then_some(raw.cfa.clone()));
        }
    }

    fn png(image: DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).expect("encoded");
        bytes.into_inner()
    }

    #[rstest]
    #[case::grey(DynamicImage::ImageLuma8(ImageBuffer::from_raw(1, 1, vec![7]).expect("one pixel")), &[("Y", 7.0)], 255.0)]
    #[case::grey_alpha(DynamicImage::ImageLumaA8(ImageBuffer::from_raw(1, 1, vec![7, 9]).expect("one pixel")), &[("Y", 7.0), ("A", 9.0)], 255.0)]
    #[case::colour(DynamicImage::ImageRgb8(ImageBuffer::from_raw(1, 1, vec![1, 2, 3]).expect("one pixel")), &[("R", 1.0), ("G", 2.0), ("B", 3.0)], 255.0)]
    #[case::colour_16(DynamicImage::ImageRgb16(ImageBuffer::from_raw(1, 1, vec![1, 256, 65535]).expect("one pixel")), &[("R", 1.0), ("G", 256.0), ("B", 65535.0)], 65535.0)]
    #[case::alpha_16(DynamicImage::ImageRgba16(ImageBuffer::from_raw(1, 1, vec![1, 2, 3, 258]).expect("one pixel")), &[("R", 1.0), ("G", 2.0), ("B", 3.0), ("A", 258.0)], 65535.0)]
    fn codes_of_png_files_are_kept(
        #[case] image: DynamicImage,
        #[case] expected: &[(&str, f32)],
        #[case] full_scale: f64,
    ) {
        let read = read("png", &png(image)).expect("read");
        let found: Vec<_> = read.mean.channels().iter().map(|c| (&c.name[..], c.data[0])).collect();
        assert_eq!(found, expected);
        assert_eq!(read.full_scale, Some(full_scale));
    }

    #[test]
    fn tiff_files_keep_their_numbers() {
        fn tiff<C: colortype::ColorType>(values: &[C::Inner]) -> Vec<u8>
        where
            [C::Inner]: tiff::encoder::TiffValue,
        {
            let mut file = Cursor::new(Vec::new());
            TiffEncoder::new(&mut file).and_then(|mut e| e.write_image::<C>(1, 1, values)).expect("written");
            file.into_inner()
        }
        for (file, expected, full_scale) in [
            (tiff::<colortype::Gray8>(&[7]), vec![("Y", 7.0)], Some(255.0)),
            (tiff::<colortype::RGB8>(&[1, 2, 3]), vec![("R", 1.0), ("G", 2.0), ("B", 3.0)], Some(255.0)),
            (tiff::<colortype::RGB16>(&[1, 258, 3]), vec![("R", 1.0), ("G", 258.0), ("B", 3.0)], Some(65_535.0)),
            (tiff::<colortype::Gray32Float>(&[-0.5]), vec![("Y", -0.5)], None),
            (tiff::<colortype::RGB32Float>(&[0.5, 2.0, 1e9]), vec![("R", 0.5), ("G", 2.0), ("B", 1e9)], None),
        ] {
            let image = read("tif", &file).expect("read");
            let found: Vec<_> = image.mean.channels().iter().map(|c| (&c.name[..], c.data[0])).collect();
            assert_eq!((found, image.full_scale), (expected, full_scale));
        }
        let error = read("tif", &tiff::<colortype::Gray32>(&[7])).expect_err("refused");
        assert!(error.to_string().contains("Gray(32)"), "{error}");
    }

    #[test]
    fn files_that_are_not_what_they_say_are_refused_by_name() {
        for extension in ["exr", "dng", "npy", "pgm", "tif", "png"] {
            let error = read(extension, b"nothing of the kind").expect_err("refused");
            assert!(
                matches!(error, Error::Input(_)) && error.to_string().contains(&format!(".{extension}: ")),
                "{error}"
            );
        }
        assert!(matches!(read("docx", b""), Err(Error::Usage { .. })));
        assert!(matches!(read_image_file(Path::new("nowhere.exr"), Pixels::Active), Err(Error::Io { .. })));
    }
}
