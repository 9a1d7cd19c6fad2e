//! Objects: what ground truth tells apart, and what stands in one pose.

use std::ops::Range;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::mesh::pose_at;

/// Instances that make one object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectDescription {
    /// Its name.
    pub name: String,
    /// What kind of object it is, if that is known.
    pub category: Option<String>,
    /// Object space → world.
    pub to_world: DAffine3,
    /// The same at the evenly spaced times that follow in the time of the picture, where it moves.
    pub later: Vec<DAffine3>,
    /// Points of it that are known by name, in object space.
    pub keypoints: Vec<(String, DVec3)>,
    /// Indices of its instances; not empty.
    pub instances: Range<usize>,
}

impl ObjectDescription {
    /// Object space → world when this part of the picture's time, 0 to 1, has gone by.
    pub fn at(&self, time: f64) -> DAffine3 {
        pose_at(&self.to_world, &self.later, time)
    }
}

/// A frame that is turned and moved against the world, and not scaled: that of an object without its scale → world. Of a
/// frame that is skewed or mirrored, which has no rotation, the origin remains, with the axes of the world.
pub fn rigid(to_world: &DAffine3) -> DAffine3 {
    let DMat3 { x_axis, y_axis, z_axis } = to_world.matrix3;
    let axes = DMat3::from_cols(x_axis.normalize(), y_axis.normalize(), z_axis.normalize());
    let is_rotation = (axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, 1e-6) && axes.determinant() > 0.0;
    let rotation = if is_rotation { DQuat::from_mat3(&axes).normalize() } else { DQuat::IDENTITY };
    DAffine3::from_rotation_translation(rotation, to_world.translation)
}
