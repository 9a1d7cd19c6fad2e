//! What a report says of the developed image.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::camera::camera_matrix;
use crate::optics::{Intrinsics, Projection};

/// The camera that `image.png` is a picture of, in the same conventions: that of `camera`, where the distortion of the
/// lens is left in, pixels keep their shape, and all of the sensor is read out pixel by pixel; else the one that a
/// developer makes of it. It stands where that one stands.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct ImageReport {
    /// Columns and rows.
    pub resolution_px: [usize; 2],
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
    /// As that of the camera.
    pub camera_matrix: [[f64; 3]; 3],
    /// The model of the lens that it shows.
    pub projection: String,
    /// Its coefficients.
    pub distortion: Vec<f64>,
    /// Mirror parameter of an omnidirectional lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub xi: Option<f64>,
    /// Whether it shows things in other places than the raw picture does.
    pub is_resampled: bool,
}

impl ImageReport {
    /// Of an image with these intrinsics and that projection.
    pub fn new(
        resolution_px: [usize; 2],
        pixel_aspect: f64,
        intrinsics: &Intrinsics,
        projection: &Projection,
        is_resampled: bool,
    ) -> Self {
        Self {
            resolution_px,
            pixel_aspect,
            camera_matrix: camera_matrix(intrinsics),
            projection: projection.name().to_owned(),
            distortion: projection.coefficients(),
            xi: projection.xi(),
            is_resampled,
        }
    }
}
