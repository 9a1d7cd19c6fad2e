//! Pictures as comparison sees them.

use crate::raw::{Cfa, PixelArea, Pixels, RawImage};
use photosite_core::Invalid;
use photosite_core::image::Planes;

/// What the plane of a raw picture is called.
pub const MOSAIC: &str = "raw";

/// A picture to be compared, whatever file it came from.
#[derive(Clone, Debug)]
pub struct Picture {
    /// What messages call it.
    pub name: String,
    /// The numbers themselves; of a Monte Carlo estimate, its mean.
    pub mean: Planes,
    /// Variances of the numbers, in the squared unit, in planes of the same names. Those not known are missing.
    pub variance: Planes,
    /// What the numbers count, where the file says so: "e-", "DN". Pictures of different units are not compared.
    pub unit: Option<String>,
    /// The largest number that can occur, where there is one.
    pub full_scale: Option<f64>,
    /// Which channel each pixel of the only plane belongs to, where it is the mosaic of a colour sensor.
    pub mosaic: Option<Cfa>,
    /// The part of its file that it shows, where the masked pixels around are left out.
    pub active_area: Option<PixelArea>,
    /// What its file says of the meaning of its numbers besides the unit, such as chromaticities.
    pub stated: Vec<String>,
    /// What of its file is left out, filled in or rounded.
    pub warnings: Vec<String>,
    /// What its file states besides and nothing here follows, such as an orientation, each with the name of the file.
    pub notes: Vec<String>,
}

impl Picture {
    /// A raw picture: the digital numbers as they are, black level included. A mosaic is one plane, [`MOSAIC`]; a
    /// picture that has all channels at every pixel is a plane of each.
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
            name,
            variance: Planes::zeros(raw.width, raw.height, [""; 0]),
            mean,
            unit: Some("DN".to_owned()),
            full_scale: Some(f64::from(raw.white_level_dn)),
            mosaic: (!raw.cfa.is_mono() && !raw.cfa.is_full()).then_some(raw.cfa),
            active_area,
            stated: Vec::new(),
            warnings: Vec::new(),
            notes: raw.metadata.left_out,
        }
    }

    /// All that is to be said of its file, each with the name of the file.
    pub fn said(&self) -> impl Iterator<Item = String> {
        let named = |what: &String| format!("{}: {what}", self.name);
        self.warnings.iter().map(named).chain(self.notes.iter().cloned())
    }

    /// A picture of numbers that are measured, of which nothing may be left out, filled in or rounded.
    pub fn whole(self) -> Result<Self, Invalid> {
        match self.warnings.first() {
            None => Ok(self),
            Some(warning) => Err(Invalid::new("", warning.clone()).help("give a file of one picture as a whole")),
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

    /// A picture of these channels, without variances.
    pub(in crate::validation) fn picture(width: usize, height: usize, channels: &[(&str, &[f32])]) -> Picture {
        Picture {
            name: format!("{width} × {height}"),
            mean: planes(width, height, channels),
            variance: planes(width, height, &[]),
            unit: None,
            full_scale: None,
            mosaic: None,
            active_area: None,
            stated: Vec::new(),
            warnings: Vec::new(),
            notes: Vec::new(),
        }
    }

    impl Picture {
        pub(in crate::validation) fn with_variances(self, variances: &[(&str, &[f32])]) -> Self {
            Self { variance: planes(self.mean.width(), self.mean.height(), variances), ..self }
        }
    }
}
