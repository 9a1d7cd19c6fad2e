//! Groups of a camera's images by what they were taken of.

use photosite_core::Result;
use photosite_core::units::{Celsius, Seconds};

/// Images taken with the same exposure time of the same light.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameGroup {
    /// Name for messages, such as that of the first file.
    pub name: String,
    /// Exposure time, where it is known.
    pub time: Option<Seconds>,
    /// Light on the pixels.
    pub light: FrameLight,
    /// Temperature of the sensor, where it is known.
    pub temperature: Option<Celsius>,
    /// Names of the images.
    pub images: Vec<String>,
}

/// Light of an image of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameLight {
    /// Darkness.
    Dark,
    /// Even light, with the number of photons on the area of each pixel, where it was measured.
    Bright {
        /// μ_p.
        photons: Option<f64>,
    },
}

impl FrameGroup {
    /// Whether the images are dark.
    pub fn is_dark(&self) -> bool {
        self.light == FrameLight::Dark
    }

    /// Photons per pixel, where they are known; none in the dark.
    pub fn photons(&self) -> Option<f64> {
        match self.light {
            FrameLight::Dark => Some(0.0),
            FrameLight::Bright { photons } => photons,
        }
    }
}

/// Images of a camera as a fit needs them: digital numbers of one plane, read as often as they are needed.
pub struct CameraFrames<'a> {
    /// Groups of images.
    pub groups: &'a [FrameGroup],
    /// Columns and rows of every image.
    pub size: [usize; 2],
    /// Bits of the digital numbers.
    pub bits: u32,
    /// Reader of an image by the numbers of its group and of its place there.
    pub read: &'a dyn Fn(usize, usize) -> Result<Vec<u16>>,
}

impl CameraFrames<'_> {
    /// Largest number of the converter.
    pub fn largest(&self) -> u16 {
        ((1u32 << self.bits.min(16)) - 1) as u16
    }
}
