//! Meshes and their instances as files describe them.

use glam::{DAffine3, Vec2, Vec3, Vec4};

use crate::geometry::{Motion, QuadricKind};

/// An indexed triangle mesh in its own space.
#[derive(Clone, Debug, Default)]
pub struct MeshDescription {
    /// Name in the file, for messages.
    pub name: String,
    /// Index of the material.
    pub material: usize,
    /// Corners, metres. Finite.
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
    /// The shapes that follow in the time of the picture, at evenly spaced times, where the mesh deforms.
    pub later_shapes: Vec<ShapeDescription>,
    /// The unit shape that it is in place of triangles; see [`of_quadric`](Self::of_quadric).
    pub quadric: Option<QuadricKind>,
}

impl MeshDescription {
    /// A quadric of unit size, for one instance that moves, turns and scales it. `positions` are corners of a box
    /// around it.
    pub fn of_quadric(kind: QuadricKind, name: String, material: usize) -> Self {
        Self { name, material, positions: kind.corners(), quadric: Some(kind), ..Self::default() }
    }
}

/// Where the corners of a mesh have gone.
#[derive(Clone, Debug, Default)]
pub struct ShapeDescription {
    /// Corners, metres. Finite, as many as in the first shape.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per position, or empty if the first shape has none.
    pub normals: Vec<Vec3>,
}

/// A mesh somewhere in the world.
#[derive(Clone, Debug)]
pub struct InstanceDescription {
    /// Name of the node, for messages.
    pub name: String,
    /// Index of the mesh.
    pub mesh: usize,
    /// Mesh space → world. Finite and invertible.
    pub to_world: DAffine3,
    /// The same at the evenly spaced times that follow in the time of the picture, where it moves.
    pub later: Vec<DAffine3>,
}

impl InstanceDescription {
    /// Mesh space → world when this part of the picture's time, 0 to 1, has gone by.
    pub fn at(&self, time: f32) -> DAffine3 {
        if self.later.iter().all(|pose| *pose == self.to_world) {
            return self.to_world;
        }
        let poses: Vec<DAffine3> = [&self.to_world].into_iter().chain(&self.later).copied().collect();
        Motion::new(&poses).to_world(time)
    }
}
