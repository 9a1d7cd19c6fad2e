//! The cameras of a data set's rig.

use glam::DAffine3;

use photosite_transport::optics::Camera;

/// What a description says of a camera of the rig.
#[derive(Clone, Debug)]
pub struct RigPlace {
    /// What its folder is called.
    pub name: String,
    /// Camera → rig.
    pub in_rig: DAffine3,
    /// Index of the camera that disparity leads to.
    pub partner: Option<usize>,
    /// Changes to the capture for this camera, in all frames.
    pub set: Vec<String>,
    /// Whether its own changes name its serial number.
    pub is_numbered: bool,
}

/// A camera of the rig.
#[derive(Clone, Debug)]
pub struct RigCamera {
    /// Its place, as stated.
    pub place: RigPlace,
    /// The camera, wherever it stands, as the capture makes it.
    pub camera: Camera,
    /// Serial number of its sensor.
    pub serial: u64,
    /// The seed that its capture states.
    pub seed: u64,
    /// Whether flow of ground truth is asked of it.
    pub flows: bool,
    /// Whether anything in its scene moves by itself.
    pub scene_moves: bool,
}
