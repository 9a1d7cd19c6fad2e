//! Meshes and their instances as files describe them.

use std::ops::Range;

use glam::{DAffine3, Vec2, Vec3, Vec4};

use crate::geometry::{Motion, QuadricKind};

/// An indexed triangle mesh in its own space.
#[derive(Clone, Debug, Default)]
pub struct MeshDescription {
    /// Name in the file, for messages.
    pub name: String,
    /// Index of the material.
    pub material: usize,
    /// Corners, metres. Finite, each of a triangle: they say how far the mesh reaches.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per position, or empty: then the mesh is flat-shaded by its geometric normals.
    pub normals: Vec<Vec3>,
    /// Tangents with handedness in w (glTF), one per position, or empty.
    pub tangents: Vec<Vec4>,
    /// UV sets, each with one entry per position; at most two.
    pub uvs: Vec<Vec<Vec2>>,
    /// Linear RGBA, 0–1, that multiplies the base colour, one per position, or empty.
    pub colours: Vec<Vec4>,
    /// Corner indices, counter-clockwise seen from the front. In range, no triangle of zero area.
    pub triangles: Vec<[u32; 3]>,
    /// The shapes that follow in the time of the image, at evenly spaced times, where the mesh deforms.
    pub later_shapes: Vec<ShapeDescription>,
    /// Unit shape that replaces triangles; see [`of_quadric`](Self::of_quadric).
    pub quadric: Option<QuadricKind>,
}

impl MeshDescription {
    /// Makes a quadric of unit size, for one instance that moves, turns and scales it. `positions` are corners of a box
    /// around it.
    pub fn of_quadric(kind: QuadricKind, name: String, material: usize) -> Self {
        Self { name, material, positions: kind.corners(), quadric: Some(kind), ..Self::default() }
    }
}

/// Shape of a mesh that deforms, at one time.
#[derive(Clone, Debug, Default)]
pub struct ShapeDescription {
    /// Corners, metres. Finite, as many as in the first shape.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per position, or empty if the first shape has none.
    pub normals: Vec<Vec3>,
}

/// Instance of meshes somewhere in the world.
#[derive(Clone, Debug)]
pub struct InstanceDescription {
    /// Name of the node, for messages.
    pub name: String,
    /// Indices of the instance's meshes: one, or several that stand together.
    pub meshes: Range<usize>,
    /// Transform mesh space → world. Finite and invertible.
    pub to_world: DAffine3,
    /// Transforms mesh space → world at the evenly spaced times that follow in the time of the image, where the
    /// instance moves.
    pub later: Vec<DAffine3>,
    /// Whether the meshes have a hierarchy of their own even if no other instance shares them: then a scene in which
    /// the instance stands elsewhere is [built](crate::scene::build_after) without building that hierarchy again.
    pub is_movable: bool,
}

impl InstanceDescription {
    /// A single mesh that stands still.
    pub fn of_mesh(name: impl Into<String>, mesh: usize, to_world: DAffine3) -> Self {
        Self { name: name.into(), meshes: mesh..mesh + 1, to_world, later: Vec::new(), is_movable: false }
    }

    /// Transform mesh space → world when a part of the image's time, 0 to 1, has gone by.
    pub fn at(&self, time: f64) -> DAffine3 {
        pose_at(&self.to_world, &self.later, time)
    }
}

/// Pose on a way through evenly spaced poses when a part of the way's time, 0 to 1, has gone by.
pub fn pose_at(first: &DAffine3, later: &[DAffine3], time: f64) -> DAffine3 {
    if later.iter().all(|pose| pose == first) {
        return *first;
    }
    let poses: Vec<DAffine3> = [first].into_iter().chain(later).copied().collect();
    Motion::new(&poses).to_world(time)
}
