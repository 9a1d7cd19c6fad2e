//! Triangles and their vertices as flat tables, for all meshes of a scene together.

use glam::{Vec2, Vec3, Vec4};

/// Corner indices into the vertex tables, and the mesh that the triangle belongs to.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Indices into [`Geometry::positions`].
    pub corners: [u32; 3],
    /// Index into [`Geometry::meshes`].
    pub mesh: u32,
}

/// What the triangles of a mesh have in common.
#[derive(Clone, Copy, Debug)]
pub struct MeshRange {
    /// Handle of the material.
    pub material: u32,
    /// Handle of the first triangle.
    pub first_triangle: u32,
    /// Number of triangles.
    pub triangle_count: u32,
    /// Handle of the light of the first triangle, where the material emits; those of the others follow.
    pub first_light: Option<u32>,
    /// What to subtract from a corner index to index [`Geometry::normals`]; `None` for flat shading.
    pub normals_from: Option<u32>,
    /// The same for [`Geometry::tangents`].
    pub tangents_from: Option<u32>,
    /// The same for each UV set.
    pub uvs_from: [Option<u32>; 2],
    /// The same for [`Geometry::colours`].
    pub colours_from: Option<u32>,
}

/// Flat tables of all geometry. Attributes that a mesh lacks take no room: each mesh says where its own begin.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// Corners, m; in world space for placed meshes, in mesh space for instanced ones.
    pub positions: Vec<Vec3>,
    /// Unit shading normals.
    pub normals: Vec<Vec3>,
    /// Tangents with handedness.
    pub tangents: Vec<Vec4>,
    /// UV coordinates.
    pub uvs: [Vec<Vec2>; 2],
    /// Linear RGBA.
    pub colours: Vec<Vec4>,
    /// All triangles.
    pub triangles: Vec<Triangle>,
    /// Their meshes.
    pub meshes: Vec<MeshRange>,
}

impl Geometry {
    /// Corner positions of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].corners.map(|corner| self.positions[corner as usize])
    }

    /// UV coordinates at a barycentric point, where the mesh has that set.
    #[inline]
    pub fn uv(&self, triangle: u32, barycentric: [f32; 2], set: usize) -> Vec2 {
        let triangle = &self.triangles[triangle as usize];
        let uvs = &self.uvs[set];
        match self.meshes[triangle.mesh as usize].uvs_from[set] {
            Some(from) => interpolate(triangle.corners.map(|c| uvs[(c - from) as usize]), barycentric),
            None => Vec2::ZERO,
        }
    }

    /// Linear RGBA at a barycentric point, where the mesh has colours.
    #[inline]
    pub fn colour(&self, triangle: u32, barycentric: [f32; 2]) -> Option<Vec4> {
        let triangle = &self.triangles[triangle as usize];
        let from = self.meshes[triangle.mesh as usize].colours_from?;
        Some(interpolate(triangle.corners.map(|c| self.colours[(c - from) as usize]), barycentric))
    }
}

/// Linear interpolation over a triangle; `[b1, b2]` are the weights of the second and third corner.
#[inline]
pub(super) fn interpolate<T>([a, b, c]: [T; 3], [b1, b2]: [f32; 2]) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    a * (1.0 - b1 - b2) + b * b1 + c * b2
}
