//! Where something is at a time.

use glam::{DAffine3, DQuat, DVec3};

/// Where something is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedPose {
    /// s, from the start of the first picture.
    pub time_s: f64,
    /// Its origin in the world, m.
    pub position_m: DVec3,
    /// Its own axes → world.
    pub rotation: DQuat,
}

impl TimedPose {
    /// Where something of that pose, its own axes → world, is at that time, s.
    pub fn new(time_s: f64, to_world: &DAffine3) -> Self {
        Self { time_s, position_m: to_world.translation, rotation: DQuat::from_mat3(&to_world.matrix3) }
    }

    /// Its own axes → world.
    pub fn to_world(&self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.rotation, self.position_m)
    }
}
