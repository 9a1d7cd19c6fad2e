//! Files that can be developed: raw files, and images that are light already.
//!
//! | file | is |
//! |---|---|
//! | PNG, JPEG | an image: codes become linear light by what the file says of its colours |
//! | PNG of 16 bits of grey that says nothing of colours | numbers of a monochrome sensor |
//! | EXR of an image, Radiance HDR | an image: [linear light](photosite_scene_io::linear) |
//! | EXR of digital numbers, and all other files | raw, as [`read_raw`] has it |
//!
//! The pixel aspect ratio is that of pHYs in PNG files, and of the header in EXR and HDR files. [`ImageNotes`] lists
//! the other statements of files, followed and left out.

use std::path::Path;
use std::sync::Arc;

use super::exr::read_exr_file;
use super::formats::{EXR, Format, Holds};
use super::image_notes::ImageNotes;
use super::linear_image::{LinearFile, read_linear_image};
use super::raw_file::{read_raw, silent_formats};
use photosite_core::image::Planes;
use photosite_core::{Invalid, Result};
use photosite_measure::validation::MOSAIC;
use photosite_raw::{Cfa, Orientation, Pixels, RawImage, RawMetadata};

/// Content of a file that can be developed.
#[derive(Clone, Debug)]
pub enum Developable {
    /// Digital numbers of a sensor.
    Raw(Arc<RawImage>),
    /// Image as light.
    Light(Light),
}

/// Image as linear light.
#[derive(Clone, Debug)]
pub struct Light {
    /// Linear R, G and B of sRGB, or Y, white at 1.
    pub planes: Planes,
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
    /// Turn that brings the image upright.
    pub orientation: Orientation,
    /// Warnings: statements of the file that are left out, pixels that are filled in or not finite.
    pub warnings: Vec<String>,
}

/// Reads a file of digital numbers.
///
/// # Errors
///
/// A file that cannot be read, or that holds an image.
pub fn read_digital_numbers(path: &Path) -> Result<Arc<RawImage>> {
    match read_developable(path)? {
        Developable::Raw(raw) => Ok(raw),
        Developable::Light(_) => {
            let help = format!("give a {} file, a raw.exr, or a PNG file of 16 bits of grey", silent_formats());
            Err(Invalid::new("", "is an image that has been developed already").help(help).in_file(path))
        }
    }
}

/// Reads a file, of the kind that its extension says.
pub fn read_developable(path: &Path) -> Result<Developable> {
    match Format::of(path).filter(|format| format.reads_images()) {
        Some(format) if *format == EXR => of_exr(path),
        Some(Format { holds: Holds::Codes | Holds::Light, .. }) => of_image(path),
        Some(_) | None => of_raw(path),
    }
}

fn of_raw(path: &Path) -> Result<Developable> {
    Ok(Developable::Raw(Arc::new(read_raw(path)?)))
}

fn of_exr(path: &Path) -> Result<Developable> {
    let image = read_exr_file(path)?;
    match image.text("unit") {
        Some("DN") => of_raw(path),
        Some(unit) => {
            let message = format!("holds a quantity in {unit}, not an image");
            let help = "photosite expose makes a raw file of electrons.exr; develop that";
            Err(Invalid::new("unit", message).help(help).in_file(path))
        }
        None => of_image(path),
    }
}

fn of_image(path: &Path) -> Result<Developable> {
    let LinearFile { light, notes } = read_linear_image(path, false, Pixels::Active)?;
    let ImageNotes { orientation, left_out, .. } = notes;
    let size = [light.planes.width(), light.planes.height()];
    if let [mosaic] = light.planes.channels()
        && mosaic.name == MOSAIC
    {
        let numbers = mosaic.data.iter().map(|&number| number as u16).collect();
        let metadata = RawMetadata { orientation, left_out, ..RawMetadata::default() };
        let raw = RawImage { metadata, ..RawImage::bare(size[0], size[1], numbers, Cfa::mono(), u16::MAX) };
        return Ok(Developable::Raw(Arc::new(raw)));
    }
    if light.components == 0 {
        let message = format!("holds no image, but the planes {}", light.others().join(", "));
        let help = "give a file with R, G and B, with X, Y and Z, or with Y, or with one layer of them";
        return Err(Invalid::new("", message).help(help).in_file(path));
    }
    let others = light.left_out().map(|what| format!("{}: {what}", path.display()));
    let warnings = others.into_iter().chain(left_out).collect();
    let pixel_aspect = light.pixel_aspect;
    let mut channels = light.planes.into_channels();
    channels.truncate(light.components);
    let planes = Planes::new(size[0], size[1], channels).map_err(|invalid| invalid.in_file(path))?;
    Ok(Developable::Light(Light { planes, pixel_aspect, orientation, warnings }))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::developed::{write_linear, write_png};
    use crate::exr::{Attribute, write_exr};
    use crate::raw_file::save_raw;
    use photosite_core::colour::ColourSpace;
    use photosite_core::image::Channel;
    use photosite_develop::EncodedImage;

    fn file(name: &str, bytes: &[u8]) -> Result<Developable> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        read_developable(&path)
    }

    fn exr(planes: &Planes, attributes: &[(&str, Attribute)]) -> Result<Developable> {
        let mut bytes = Cursor::new(Vec::new());
        write_exr(planes, attributes, &mut bytes).expect("written");
        file("picture.exr", bytes.get_ref())
    }

    #[test]
    fn images_become_light_with_the_shape_of_their_pixels() {
        let grey = EncodedImage { pixel_aspect: 1.5, ..EncodedImage::srgb8(2, 1, 1, vec![0, 128]) };
        let mut bytes = Vec::new();
        write_png(&grey, &mut bytes).expect("written");
        let Developable::Light(light) = file("grey.png", &bytes).expect("an image") else { panic!("not a raw file") };
        // ((128/255 + 0.055)/1.055)^2.4 by a calculator.
        assert!((light.planes.plane("Y").expect("grey")[1] - 0.215_861).abs() < 1e-4);
        assert!((light.pixel_aspect - 1.5).abs() < 1e-5 && light.warnings.is_empty());

        let xyz = ColourSpace::Xyz.white().as_vec3().to_array();
        let channel = |(name, v): (&str, f32)| Channel { name: name.to_owned(), data: vec![v] };
        let white = Planes::new(1, 1, ["X", "Y", "Z"].into_iter().zip(xyz).map(channel).collect()).expect("right");
        let mut bytes = Cursor::new(Vec::new());
        write_linear(&white, ColourSpace::Xyz, 0.5, &mut bytes).expect("written");
        let Developable::Light(light) = file("white.exr", bytes.get_ref()).expect("an image") else {
            panic!("not a raw file")
        };
        assert!(["R", "G", "B"].iter().all(|name| (light.planes.plane(name).expect("there")[0] - 1.0).abs() < 1e-5));
        assert_eq!(light.pixel_aspect, 0.5);
    }

    #[test]
    fn what_has_no_part_is_named_and_what_is_no_image_refused() {
        let with_alpha = exr(&Planes::zeros(2, 2, ["A", "B", "G", "R"]), &[]).expect("an image");
        let Developable::Light(light) = with_alpha else { panic!("not a raw file") };
        assert!(light.warnings[0].contains("its planes, A have no part"));
        for (planes, attributes, complaint) in [
            (["depth.Z"], vec![], "depth.Z"),
            (["Y"], vec![("unit", Attribute::Text("e-".to_owned()))], "a quantity in e-"),
        ] {
            let error = exr(&Planes::zeros(1, 1, planes), &attributes).expect_err("refused");
            assert!(error.to_string().contains(complaint), "{error}");
        }
        assert!(file("picture.png", b"nothing of the kind").is_err());
    }

    #[test]
    fn raw_files_come_back_and_images_are_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let raw = RawImage::bare(2, 1, vec![3, 900], Cfa::mono(), 1023);
        for name in ["raw.exr", "raw.EXR", "raw.npy", "raw.dng"] {
            save_raw(&raw, folder.path().join(name)).expect("written");
            let read = read_digital_numbers(&folder.path().join(name)).expect("digital numbers");
            assert_eq!(read.data, raw.data, "{name}");
        }
        assert!(save_raw(&raw, folder.path().join("raw.jpg")).is_err());
        let path = folder.path().join("picture.exr");
        let planes = Planes::zeros(1, 1, ["R", "G", "B"]);
        photosite_core::output::write_whole(&path, |to| write_exr(&planes, &[], to)).expect("written");
        let error = read_digital_numbers(&path).expect_err("not a raw file").to_string();
        assert!(error.contains("developed already"), "{error}");
    }

    #[test]
    fn grey_of_16_bits_that_says_nothing_is_raw() {
        let mut bytes = Vec::new();
        crate::plain_png::write_grey16([2, 1], &[7, 60_000], &mut bytes).expect("written");
        let Developable::Raw(raw) = file("mosaic.png", &bytes).expect("numbers") else { panic!("no colours") };
        assert_eq!((&raw.data[..], raw.white_level_dn), (&[7, 60_000][..], u16::MAX));
    }
}
