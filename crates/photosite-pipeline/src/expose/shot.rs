//! Shot: an exposure in memory.

use std::sync::Arc;

use super::frame_series::Carried;
use crate::DevelopedImage;
use photosite_core::Result;
use photosite_core::image::Estimate;
use photosite_develop::DevelopSettings;
use photosite_raw::RawImage;
use photosite_sensor::{Exposure, NoiseMaps};

/// Result of one exposure: the raw image with the electrons and the noise that it is made of.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Number of the frame in its series.
    pub frame: u32,
    /// Raw image: digital numbers with all that raw files state of them.
    pub raw: RawImage,
    /// The exposure, of an automatic one as it was found.
    pub exposure: Exposure,
    /// Mean electrons of each channel and their variance from light transport, e⁻ and (e⁻)².
    pub electrons: Arc<Estimate>,
    /// Noise maps that were asked for: the contribution of an effect to each digital number.
    pub noise_maps: NoiseMaps,
    /// Graphics card that has exposed; `None` for the processor.
    pub device: Option<String>,
    /// Warnings about the exposure.
    pub warnings: Vec<String>,
    /// State after the frames before it.
    pub(crate) before: Carried,
}

impl Shot {
    /// Develops the raw image.
    ///
    /// # Errors
    ///
    /// Errors of [`DevelopedImage::develop`].
    pub fn develop(&self, settings: &DevelopSettings) -> Result<DevelopedImage> {
        DevelopedImage::develop(&self.raw, settings)
    }
}
