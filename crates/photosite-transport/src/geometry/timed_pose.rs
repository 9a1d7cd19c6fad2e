//! Pose of a camera or an object at a time.

use glam::{DAffine3, DQuat, DVec3};

/// Pose of a camera or an object at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedPose {
    /// Time, s, from the start of the first image.
    pub time_s: f64,
    /// Origin of its own axes in the world, m.
    pub position_m: DVec3,
    /// Rotation from its own axes to the world.
    pub rotation: DQuat,
}

impl TimedPose {
    /// Makes a pose of a time, s, from a transform, own axes → world.
    pub fn new(time_s: f64, to_world: &DAffine3) -> Self {
        Self { time_s, position_m: to_world.translation, rotation: DQuat::from_mat3(&to_world.matrix3) }
    }

    /// Transform from its own axes to the world.
    pub fn to_world(&self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.rotation, self.position_m)
    }
}
