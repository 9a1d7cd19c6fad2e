//! The formats of developed pictures: what names say them, what they hold, and what settings they cannot.

use std::path::Path;

use crate::colour::ColourSpace;
use crate::develop::{ColourModel, DevelopSettings};
use crate::image::Planes;
use crate::{Error, Invalid, Result};

/// Formats of developed pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// Portable network graphics.
    Png,
    /// Tagged image file format.
    Tiff,
    /// JPEG.
    Jpeg,
    /// Portable greymap.
    Pgm,
    /// Portable pixmap, or greymap.
    Ppm,
    /// OpenEXR.
    Exr,
    /// NumPy array.
    Npy,
}

/// What the numbers of a file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Numbers {
    /// Codes of a picture for display.
    Codes,
    /// Linear components of the colour space.
    Linear,
    /// Those of a colour model.
    Model,
}

impl PictureFormat {
    /// The format that a file's name says.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "png" => Ok(Self::Png),
            "tif" | "tiff" => Ok(Self::Tiff),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            "pgm" => Ok(Self::Pgm),
            "ppm" => Ok(Self::Ppm),
            "exr" => Ok(Self::Exr),
            "npy" => Ok(Self::Npy),
            _ => Err(Error::Usage {
                message: format!("{} is not the name of a picture that photosite can write", path.display()),
                help: Some("give a name that ends with .png, .tiff, .jpg, .pgm, .ppm, .exr or .npy".into()),
            }),
        }
    }

    /// What the file holds of a picture that is developed so.
    pub(super) fn numbers(self, settings: &DevelopSettings) -> Numbers {
        match (self, settings.colour_model) {
            (Self::Png | Self::Jpeg | Self::Pgm | Self::Ppm, _) | (Self::Tiff, ColourModel::Grey) => Numbers::Codes,
            (Self::Tiff, ColourModel::Rgb) if settings.colour_space != ColourSpace::Xyz => Numbers::Codes,
            (Self::Tiff | Self::Exr | Self::Npy, ColourModel::Rgb | ColourModel::Grey) => Numbers::Linear,
            (
                Self::Tiff | Self::Exr | Self::Npy,
                ColourModel::EncodedGrey | ColourModel::Hsv | ColourModel::Hsl | ColourModel::Hsi | ColourModel::Lab,
            ) => Numbers::Model,
        }
    }

    /// Refuses settings that the format cannot hold.
    pub fn check(self, settings: &DevelopSettings) -> Result<(), Invalid> {
        let numbers = self.numbers(settings);
        if self == Self::Jpeg && settings.bits != 8 {
            return Err(Invalid::new("bits", "a JPEG file has 8 bits").help("write a .png or .tiff file"));
        }
        if numbers == Numbers::Codes && !settings.colour_model.is_shown() {
            let name = settings.colour_model.name();
            let message = format!("viewers of such a file would take the numbers of {name} for colours");
            return Err(Invalid::new("colour_model", message).help("write an .exr, .tiff or .npy file"));
        }
        if numbers == Numbers::Codes && settings.colour_space == ColourSpace::Xyz && !settings.colour_model.is_grey() {
            let message = "X and Z of white pass 1, which codes cannot hold";
            return Err(Invalid::new("colour_space", message)
                .help("write an .exr, .tiff or .npy file, or choose another colour space"));
        }
        if numbers != Numbers::Codes && settings.sharpening != 0.0 {
            let message = "sharpening works on the codes that are shown, not on the floats of this file";
            return Err(
                Invalid::new("sharpening", message).help("write a .png or .tiff file of colour_model = \"rgb\"")
            );
        }
        Ok(())
    }

    /// Keys of the settings that were given and change nothing in such a file.
    pub fn unused_keys(self, settings: &DevelopSettings) -> Vec<&'static str> {
        let default = DevelopSettings::default();
        let has_codes = self.numbers(settings) == Numbers::Codes;
        let unused = [
            ("jpeg_quality", settings.jpeg_quality != default.jpeg_quality && self != Self::Jpeg),
            ("bits", settings.bits != default.bits && !has_codes),
            ("dither", settings.dither != default.dither && !has_codes),
        ];
        unused.into_iter().filter_map(|(key, is_unused)| is_unused.then_some(key)).collect()
    }

    /// Refuses a picture that the format cannot hold.
    pub fn check_picture(self, planes: &Planes) -> Result<(), Invalid> {
        if self == Self::Pgm && planes.channels().len() != 1 {
            let names: Vec<&str> = planes.channels().iter().map(|c| &c.name[..]).collect();
            let message = format!("a PGM file holds grey, the picture has {}", names.join(", "));
            return Err(Invalid::new("", message).help("write a .ppm, .png or .tiff file"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_the_format() {
        for (name, format) in
            [("a.png", PictureFormat::Png), ("b.TIF", PictureFormat::Tiff), ("c.jpeg", PictureFormat::Jpeg)]
        {
            assert_eq!(PictureFormat::of(name.as_ref()).expect("known"), format);
        }
        assert!(PictureFormat::of("raw.dng".as_ref()).is_err() && PictureFormat::of("picture".as_ref()).is_err());
        let deep = DevelopSettings { bits: 16, ..DevelopSettings::default() };
        assert_eq!(PictureFormat::Jpeg.check(&deep).expect_err("8 bits").key, "bits");
        let xyz = DevelopSettings { colour_space: ColourSpace::Xyz, ..DevelopSettings::default() };
        assert_eq!(PictureFormat::Png.check(&xyz).expect_err("passes 1").key, "colour_space");
        assert!([PictureFormat::Exr, PictureFormat::Tiff, PictureFormat::Npy].iter().all(|f| f.check(&xyz).is_ok()));
        let lab = DevelopSettings { colour_model: ColourModel::Lab, ..DevelopSettings::default() };
        assert_eq!(PictureFormat::Jpeg.check(&lab).expect_err("no colours").key, "colour_model");
        let sharp = DevelopSettings { sharpening: 1.0, ..lab.clone() };
        assert_eq!(PictureFormat::Tiff.check(&sharp).expect_err("floats").key, "sharpening");
        let coarse = DevelopSettings { jpeg_quality: 50, bits: 16, ..lab };
        assert_eq!(PictureFormat::Tiff.unused_keys(&coarse), ["jpeg_quality", "bits"]);
    }
}
