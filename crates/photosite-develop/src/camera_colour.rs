//! Camera colours of a raw file: calibrations of the sensor and the response to the scene's white.

use super::SensorCalibration;
use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;
use photosite_raw::{ColourCalibration, RawMetadata};

pub use super::colour_matrix::{chart_error, neutral};

/// The colour entries of a raw file's metadata.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraColour {
    /// Colour calibrations of the channels in A, D65 and D50, in this order: readers that use one matrix look for that
    /// of D65 or take the second; those that use two mix the first and the second.
    pub calibrations: Vec<ColourCalibration>,
    /// The camera's response to the scene's white, the largest component 1.
    pub neutral: Vec<f64>,
}

impl CameraColour {
    /// Writes it into the metadata of a raw image.
    pub fn write_to(&self, metadata: &mut RawMetadata) {
        metadata.calibrations.clone_from(&self.calibrations);
        metadata.as_shot_neutral = Some(self.neutral.clone());
    }
}

/// Colour of a camera with these channels in a scene lit by `light` (any unit). `None` for a camera of less than three
/// channels, which sees no colours.
pub fn camera_colour(responses: &[(String, Spectrum)], light: &Spectrum) -> Result<Option<CameraColour>, Invalid> {
    let Some(found) = SensorCalibration::of(responses, None)? else { return Ok(None) };
    Ok(Some(CameraColour { calibrations: found.lights().to_vec(), neutral: neutral(responses, light)? }))
}
