//! Calibrated camera of a file.

use glam::DAffine3;
use photosite_core::projection::{Intrinsics, Projection};

use crate::camera_files::half_turn;

/// Camera of a calibration file.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Name of the camera in the file: that of its table, or its number.
    pub name: String,
    /// Camera matrix in photosite's coordinates, where the centre of the first pixel is 0.5, 0.5.
    pub intrinsics: Intrinsics,
    /// Projection of the lens.
    pub projection: Projection,
    /// Columns and rows of the images that it holds for; `None` where the file does not say.
    pub resolution: Option<[u32; 2]>,
    /// Poses of the camera.
    pub poses: Vec<StatedPose>,
    /// Assumptions, and keys of the file that are not used.
    pub warnings: Vec<String>,
}

/// Pose of a camera as a calibration states it.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedPose {
    /// Name of the frame ("world", "imu", "body", another camera), or of the image that was taken from there.
    pub name: String,
    /// Camera → frame with the axes of glTF (x right, y up, z backward) on the camera's side, m. The axes of the frame
    /// are as the file has them; those of a camera are glTF's, so that it stands upright and looks along −z.
    pub to_frame: DAffine3,
}

/// Warning about keys that mean something and are not used.
pub(super) fn unused(keys: &[String]) -> Option<String> {
    (!keys.is_empty()).then(|| format!("not used of it: {}", keys.join(", ")))
}

/// Camera → frame with glTF's axes on the camera's side, from the frame → camera of OpenCV.
pub(super) fn to_frame(from_frame: &DAffine3) -> DAffine3 {
    from_frame.inverse() * half_turn()
}
