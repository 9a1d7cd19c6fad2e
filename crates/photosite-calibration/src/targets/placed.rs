//! Targets that stand in a scene.

use glam::{DAffine3, DVec2, DVec3};

use super::{Target, TargetDescription};

/// A target in the world.
#[derive(Clone, Debug)]
pub struct PlacedTarget {
    /// Name in the capture file; materials of the target are called NAME-INK.
    pub name: String,
    /// What it is.
    pub description: TargetDescription,
    /// The same, drawn.
    pub target: Target,
    /// Frame of the target (x right, y down, z into the sheet, metres) → world: rotation and translation.
    pub to_world: DAffine3,
}

impl PlacedTarget {
    /// A place on the sheet in the world, m.
    pub fn world(&self, position_m: DVec2) -> DVec3 {
        self.to_world.transform_point3(position_m.extend(0.0))
    }

    /// The points that a calibration finds, in OpenCV's order, with their places in the world in metres.
    pub fn points(&self) -> impl Iterator<Item = (&str, DVec3)> {
        self.target.points.iter().map(|point| (point.name.as_str(), self.world(point.position_m)))
    }
}
