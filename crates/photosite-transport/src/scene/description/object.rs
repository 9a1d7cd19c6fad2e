//! Objects: instances that stand in one pose, and that ground truth tells apart.

use std::ops::Range;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::mesh::pose_at;

/// Instances that make one object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectDescription {
    /// Name of the object.
    pub name: String,
    /// Category of the object, if it is known.
    pub category: Option<String>,
    /// Transform object space → world.
    pub to_world: DAffine3,
    /// Transforms object space → world at the evenly spaced times that follow in the time of the image, where the
    /// object moves.
    pub later: Vec<DAffine3>,
    /// Keypoints of the object by name, in object space.
    pub keypoints: Vec<(String, DVec3)>,
    /// Indices of the object's instances; not empty.
    pub instances: Range<usize>,
}

impl ObjectDescription {
    /// Transform object space → world when a part of the image's time, 0 to 1, has gone by.
    pub fn at(&self, time: f64) -> DAffine3 {
        pose_at(&self.to_world, &self.later, time)
    }
}

/// Rigid frame → world of an object: its transform without the scale. Of a frame that is skewed or mirrored, which has
/// no rotation, the origin remains, with the axes of the world.
pub fn rigid(to_world: &DAffine3) -> DAffine3 {
    let DMat3 { x_axis, y_axis, z_axis } = to_world.matrix3;
    let axes = DMat3::from_cols(x_axis.normalize(), y_axis.normalize(), z_axis.normalize());
    let is_rotation = (axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, 1e-6) && axes.determinant() > 0.0;
    let rotation = if is_rotation { DQuat::from_mat3(&axes).normalize() } else { DQuat::IDENTITY };
    DAffine3::from_rotation_translation(rotation, to_world.translation)
}
