//! Images as comparison sees them.

use photosite_core::Invalid;
use photosite_core::image::Planes;
use photosite_raw::{Cfa, PixelArea, Pixels, RawImage};

/// Name of the plane of a raw image.
pub const MOSAIC: &str = "raw";

/// An image to be compared, whatever file it came from.
#[derive(Clone, Debug)]
pub struct ComparedImage {
    /// Name of the image in messages.
    pub name: String,
    /// Pixel values; for a Monte Carlo estimate, their means.
    pub mean: Planes,
    /// Variances of the pixel values, in the squared unit, in planes of the same names. Planes of unknown variance are
    /// missing.
    pub variance: Planes,
    /// Unit of the pixel values, where the file states it: "e-", "DN". Images of different units are not compared.
    pub unit: Option<String>,
    /// The largest number that can occur, where there is one.
    pub full_scale: Option<f64>,
    /// Colour filter array, where the only plane is the mosaic of a colour sensor.
    pub mosaic: Option<Cfa>,
    /// The part of its file that it shows, where the masked pixels around are left out.
    pub active_area: Option<PixelArea>,
    /// Statements of the file about the meaning of its pixel values besides the unit, such as chromaticities.
    pub stated: Vec<String>,
    /// Warnings about what of the file is left out, filled in or rounded.
    pub warnings: Vec<String>,
    /// Further statements of the file that nothing here follows, such as an orientation, each with the name of the
    /// file.
    pub notes: Vec<String>,
}

impl ComparedImage {
    /// An image of which nothing is known but its pixel values.
    pub fn plain(name: String, mean: Planes) -> Self {
        Self {
            name,
            variance: Planes::zeros(mean.width(), mean.height(), [""; 0]),
            mean,
            unit: None,
            full_scale: None,
            mosaic: None,
            active_area: None,
            stated: Vec::new(),
            warnings: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// A raw image: the digital numbers as they are, black level included. A mosaic is one plane, [`MOSAIC`]; an
    /// image that has all channels at every pixel is a plane of each.
    pub fn from_raw(name: String, raw: RawImage, pixels: Pixels) -> Self {
        let active_area = raw.active_area.filter(|_| pixels == Pixels::Active);
        let raw = match active_area {
            Some(area) => raw.part(area),
            None => raw,
        };
        let samples = raw.cfa.samples_per_pixel();
        let names = if raw.cfa.is_full() { raw.cfa.channels() } else { &[MOSAIC.to_owned()] };
        let mut mean = Planes::zeros(raw.width, raw.height, names);
        for (first, channel) in mean.channels_mut().iter_mut().enumerate() {
            channel.data = raw.data.iter().skip(first).step_by(samples).copied().map(f32::from).collect();
        }
        Self {
            unit: Some("DN".to_owned()),
            full_scale: Some(f64::from(raw.white_level_dn)),
            mosaic: (!raw.cfa.is_mono() && !raw.cfa.is_full()).then_some(raw.cfa),
            active_area,
            notes: raw.metadata.left_out,
            ..Self::plain(name, mean)
        }
    }

    /// Warnings and notes about the file, each with its name.
    pub fn said(&self) -> impl Iterator<Item = String> {
        let named = |what: &String| format!("{}: {what}", self.name);
        self.warnings.iter().map(named).chain(self.notes.iter().cloned())
    }

    /// Returns the image where it can be measured: nothing of it may be left out, filled in or rounded.
    pub fn whole(self) -> Result<Self, Invalid> {
        match self.warnings.first() {
            None => Ok(self),
            Some(warning) => Err(Invalid::new("", warning.clone()).help("give a file of one image as a whole")),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use photosite_core::image::Channel;

    fn planes(width: usize, height: usize, planes: &[(&str, &[f32])]) -> Planes {
        let channel = |&(name, data): &(&str, &[f32])| Channel { name: name.to_owned(), data: data.to_vec() };
        Planes::new(width, height, planes.iter().map(channel).collect()).expect("right sizes")
    }

    /// An image of these channels, without variances.
    pub(in crate::validation) fn image(width: usize, height: usize, channels: &[(&str, &[f32])]) -> ComparedImage {
        ComparedImage::plain(format!("{width} × {height}"), planes(width, height, channels))
    }

    impl ComparedImage {
        pub(in crate::validation) fn with_variances(self, variances: &[(&str, &[f32])]) -> Self {
            Self { variance: planes(self.mean.width(), self.mean.height(), variances), ..self }
        }
    }
}
