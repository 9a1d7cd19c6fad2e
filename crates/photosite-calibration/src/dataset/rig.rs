//! Cameras of a data set's rig.

use glam::DAffine3;

use photosite_transport::optics::Camera;

/// Camera of the rig as described.
#[derive(Clone, Debug)]
pub struct RigPlace {
    /// Name of the camera's folder.
    pub name: String,
    /// Transform camera → rig.
    pub in_rig: DAffine3,
    /// Index of the camera that disparity leads to.
    pub partner: Option<usize>,
    /// Changes to the capture for this camera, in all frames.
    pub set: Vec<String>,
    /// Whether the camera's own changes name its serial number.
    pub is_numbered: bool,
}

/// Camera of the rig.
#[derive(Clone, Debug)]
pub struct RigCamera {
    /// Description of the camera's place in the rig.
    pub place: RigPlace,
    /// Camera as the capture makes it, whatever its pose.
    pub camera: Camera,
    /// Serial number of the camera's sensor.
    pub serial: u64,
    /// Seed that the camera's capture states.
    pub seed: u64,
    /// Whether flow of ground truth is requested of the camera.
    pub flows: bool,
    /// Whether anything in the camera's scene moves by itself.
    pub scene_moves: bool,
}
