//! A developed image: from digital numbers to light in a colour space, and to a file.

use std::path::Path;

use photosite_capture::CaptureSource;
use photosite_core::image::Planes;
use photosite_core::output::write_whole;
use photosite_core::{Invalid, Result};
use photosite_develop::{
    DevelopSettings, Development, EncodedImage, RawDescription, develop_image, develop_linear, encode,
};
use photosite_files::developable::{Developable, Light};
use photosite_files::developed::{DevelopedValues, numbers, write_developed};
use photosite_files::formats::{EXR, Format};
use photosite_raw::{Orientation, PixelArea, RawImage};

/// A developed image.
#[derive(Clone, Debug)]
pub struct DevelopedImage {
    /// Linear light in the colour space of the settings, a plane for each component.
    pub linear: Planes,
    /// Findings of development: white balance, temperature, shape of the pixels.
    pub development: Development,
    settings: DevelopSettings,
}

impl DevelopedImage {
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

    /// Develops the contents of `path` by settings that stand in `source` and [suit](Format::check) the format,
    /// for a file `output` of it.
    ///
    /// # Errors
    ///
    /// Settings that do not fit what is developed: either is named by its key.
    pub fn develop_file(
        file: Developable,
        path: &Path,
        (settings, source): &(DevelopSettings, CaptureSource),
        (format, output): (&Format, &Path),
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
                warnings.extend(no_part(settings.raw_keys(), "an image that is developed already"));
                warnings.extend(of_file);
                let orientation = if settings.orientation { orientation } else { Orientation::default() };
                develop_image(orientation.apply(planes), orientation.pixel_aspect(pixel_aspect), settings)
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
        let image = Self { linear, development, settings: settings.clone() };
        Ok(DevelopedFile { image, assumed, warnings })
    }

    /// Pixel values that a file of this format holds.
    pub fn into_numbers(self, format: &Format) -> DevelopedValues {
        numbers(self.linear, &self.settings, self.development.pixel_aspect, format)
    }

    /// Encoded image, as it is shown: codes of the settings' bits, with tone curve and dither.
    pub fn encoded(&self) -> EncodedImage {
        let encoded = encode(self.linear.clone(), &self.settings.encoding());
        EncodedImage { pixel_aspect: self.development.pixel_aspect, ..encoded }
    }

    /// Writes the image in the format that the extension asks for; .exr and .npy files hold linear light. The file appears whole or not at all; an older one is replaced.
    ///
    /// # Errors
    ///
    /// An extension that is none of these, settings or an image that the format cannot hold, a folder that is not
    /// there.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        let format = Format::of_developed(path)?;
        format.check(&self.settings).map_err(|invalid| invalid.within("develop").in_file(path))?;
        format.check_image(&self.linear).map_err(|invalid| invalid.in_file(path))?;
        let aspect = self.development.pixel_aspect;
        write_whole(path, |to| write_developed(self.linear.clone(), &self.settings, aspect, format, to))
    }
}

/// An image that was developed from a file, with assumptions and warnings.
pub struct DevelopedFile {
    /// The image.
    pub image: DevelopedImage,
    /// Assumption about a file that states nothing of its pixel values.
    pub assumed: Option<String>,
    /// Warnings: parts of the file that were left out, and keys without effect.
    pub warnings: Vec<String>,
}

/// Assumption about files of pixel values alone that state nothing else.
fn assumption(path: &Path, raw: &RawImage, settings: &DevelopSettings) -> Option<String> {
    let is_exr = Format::of(path).is_some_and(|format| *format == EXR);
    if is_exr || !raw.metadata.is_silent() || settings.raw != RawDescription::default() {
        return None;
    }
    let kind = if raw.cfa.is_mono() { "a monochrome sensor" } else { "a sensor with R, G and B at every pixel" };
    let (file, white) = (path.display(), raw.white_level_dn);
    Some(format!(
        "{file} holds pixel values alone: taken for those of {kind}, linear from 0 to {white}; develop.raw says otherwise"
    ))
}
