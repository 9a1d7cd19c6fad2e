//! Report of the developed image.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::camera::camera_matrix;
use glam::DVec2;
use photosite_core::image_grid::ImageGrid;
use photosite_transport::optics::{Intrinsics, Projection};

/// Camera that `image.png` is an image of, in the same conventions: that of `camera`, where the distortion of the lens
/// is left in, pixels keep their shape, and all of the sensor is read out pixel by pixel; else the one that development
/// makes of it. It has the same pose.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct ImageReport {
    /// Columns and rows.
    pub resolution_px: [usize; 2],
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
    /// Camera matrix of the developed image, in the convention of the camera's.
    pub camera_matrix: [[f64; 3]; 3],
    /// Model of the lens that the image shows.
    pub projection: String,
    /// Distortion coefficients in OpenCV's order.
    pub distortion: Vec<f64>,
    /// Mirror parameter of an omnidirectional lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub xi: Option<f64>,
    /// Whether the developed image shows points in other places than the raw image does.
    pub is_resampled: bool,
}

impl ImageReport {
    /// Report of an image with these intrinsics and that projection.
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

/// Pixels of ground truth, points of targets and objects, and camera files: those of `image.png`, or of the raw image
/// where none is developed or where `image.png` is freed of the distortion of the lens.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct PixelGridReport {
    /// Columns and rows.
    pub resolution_px: [u32; 2],
    /// Matrix of `camera` (of the fitted model, for a lens that is traced) on these pixels.
    pub camera_matrix: [[f64; 3]; 3],
    /// Position of the top-left corner of the first pixel, in pixels of the sensor from the sensor's own corner.
    pub corner_px: [f64; 2],
    /// Size of a pixel across and down, in pixels of the sensor.
    pub sensor_px: [f64; 2],
    /// Whether every second row lies half a pixel farther to the right.
    pub is_staggered: bool,
}

impl PixelGridReport {
    /// Report of a grid, with the matrix of the camera on it.
    pub fn new(grid: &ImageGrid, intrinsics: &Intrinsics) -> Self {
        Self {
            resolution_px: grid.resolution,
            camera_matrix: camera_matrix(intrinsics),
            corner_px: grid.first.to_array(),
            sensor_px: grid.per_pixel.to_array(),
            is_staggered: grid.is_staggered,
        }
    }

    /// Whether `image.png` has these pixels and the projection of the lens, or of the model fitted to it.
    pub fn is_of(&self, image: &ImageReport, projection: &Projection) -> bool {
        image.projection == projection.name() && image.resolution_px == self.resolution_px.map(|n| n as usize)
    }

    /// Grid of the pixels.
    pub fn grid(&self) -> ImageGrid {
        ImageGrid {
            resolution: self.resolution_px,
            first: DVec2::from_array(self.corner_px),
            per_pixel: DVec2::from_array(self.sensor_px),
            is_staggered: self.is_staggered,
        }
    }
}
