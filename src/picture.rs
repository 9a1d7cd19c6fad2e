//! A developed picture: from digital numbers to light in a colour space, and to a file.

use std::path::Path;

use crate::capture::CaptureSource;
use crate::develop::{
    DevelopSettings, Development, EncodedPicture, RawDescription, develop_linear, develop_picture, encode,
};
use crate::image::Planes;
use crate::io::developable::{Developable, Light};
use crate::io::developed::{PictureFormat, PictureNumbers, numbers, write_developed};
use crate::io::output::write_whole;
use crate::raw::{Orientation, PixelArea, RawImage};
use crate::{Invalid, Result};

/// A developed picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Linear light in the colour space of the settings, a plane for each component.
    pub linear: Planes,
    /// What development found: white balance, temperature, shape of the pixels.
    pub development: Development,
    settings: DevelopSettings,
}

impl Picture {
    /// Develops a raw image, of a file or of a [`Shot`](crate::Shot).
    ///
    /// # Errors
    ///
    /// Settings that do not fit the image, such as a demosaicking that its colour filter array has no use for.
    pub fn develop(raw: &RawImage, settings: &DevelopSettings) -> Result<Self> {
        let developed = develop_linear(raw, settings);
        let (linear, development) = developed.map_err(|invalid| invalid.in_file(Path::new("develop")))?;
        Ok(Self { linear, development, settings: settings.clone() })
    }

    /// Develops what was read from `path` by settings that stand in `source` and [suit](PictureFormat::check) the format,
    /// for a file `output` of it.
    ///
    /// # Errors
    ///
    /// Settings that do not fit what is developed: either is named by its key.
    pub fn develop_file(
        file: Developable,
        path: &Path,
        (settings, source): &(DevelopSettings, CaptureSource),
        (format, output): (PictureFormat, &Path),
    ) -> Result<DevelopedFile> {
        let no_part = |keys: Vec<&str>, of: &str| {
            keys.iter().map(|key| format!("develop.{key} does not affect {of}")).collect::<Vec<_>>()
        };
        let mut warnings = no_part(format.unused_keys(settings), &output.display().to_string());
        let mut assumed = None;
        let developed = match file {
            Developable::Raw(raw) => {
                assumed = assumption(path, &raw, settings);
                warnings.extend(raw.metadata.left_out.iter().cloned());
                if let Some(area) = raw.metadata.default_crop.filter(|_| settings.default_crop) {
                    let PixelArea { width, height, .. } = raw.active();
                    warnings.push(format!(
                        "{}: DefaultCropSize leaves {area} of {width} × {height} pixels; develop.default_crop = false keeps all",
                        path.display()
                    ));
                }
                develop_linear(&raw, settings)
            }
            Developable::Light(Light { planes, pixel_aspect, orientation, warnings: of_file }) => {
                warnings.extend(no_part(settings.raw_keys(), "a picture that is developed already"));
                warnings.extend(of_file);
                let orientation = if settings.orientation { orientation } else { Orientation::default() };
                develop_picture(orientation.apply(planes), orientation.pixel_aspect(pixel_aspect), settings)
            }
        };
        // What is wrong now lies between the settings and the raw file.
        let (linear, development) = developed.map_err(|invalid: Invalid| {
            if source.has(&format!("develop.{}", invalid.key)) {
                source.error(invalid.within("develop"))
            } else {
                invalid.in_file(path)
            }
        })?;
        let picture = Self { linear, development, settings: settings.clone() };
        Ok(DevelopedFile { picture, assumed, warnings })
    }

    /// What a file of this format holds of it.
    pub fn into_numbers(self, format: PictureFormat) -> PictureNumbers {
        numbers(self.linear, &self.settings, self.development.pixel_aspect, format)
    }

    /// The picture as it is shown: codes of the settings' bits, with tone curve and dither.
    pub fn encoded(&self) -> EncodedPicture {
        let encoded = encode(self.linear.clone(), &self.settings.encoding());
        EncodedPicture { pixel_aspect: self.development.pixel_aspect, ..encoded }
    }

    /// Writes it in the format that the extension asks for: .png, .tiff, .jpg, .ppm, .pgm (grey alone), or .exr and
    /// .npy, which hold linear light. The file appears whole or not at all; an older one is replaced.
    ///
    /// # Errors
    ///
    /// An extension that is none of these, settings or a picture that the format cannot hold, a folder that is not
    /// there.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        let format = PictureFormat::of(path)?;
        format.check(&self.settings).map_err(|invalid| invalid.within("develop").in_file(path))?;
        format.check_picture(&self.linear).map_err(|invalid| invalid.in_file(path))?;
        let aspect = self.development.pixel_aspect;
        write_whole(path, |to| write_developed(self.linear.clone(), &self.settings, aspect, format, to))
    }
}

/// A picture that was developed of a file.
pub struct DevelopedFile {
    /// The picture.
    pub picture: Picture,
    /// What is taken to hold of a file that says nothing of itself.
    pub assumed: Option<String>,
    /// What was left out, and which keys had no part.
    pub warnings: Vec<String>,
}

/// What is assumed of files of numbers alone of which nothing is stated.
fn assumption(path: &Path, raw: &RawImage, settings: &DevelopSettings) -> Option<String> {
    let is_exr = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
    if is_exr || !raw.metadata.is_silent() || settings.raw != RawDescription::default() {
        return None;
    }
    let kind = if raw.cfa.is_mono() { "a monochrome sensor" } else { "a sensor with R, G and B at every pixel" };
    let (file, white) = (path.display(), raw.white_level_dn);
    Some(format!(
        "{file} holds numbers alone: taken for those of {kind}, linear from 0 to {white}; develop.raw says otherwise"
    ))
}
