//! A developed picture: from digital numbers to light in a colour space, and to a file.

use std::path::Path;

use crate::Result;
use crate::develop::{DevelopSettings, Development, EncodedPicture, develop_linear, encode};
use crate::image::Planes;
use crate::io::developed::{PictureFormat, write_developed};
use crate::io::output::write_whole;
use crate::raw::RawImage;

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
