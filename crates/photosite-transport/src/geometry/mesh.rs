//! Triangles and their vertices as flat tables, for all meshes of a scene together.

use glam::{DVec3, Vec2, Vec3, Vec4};

use super::{PlacedQuadric, Primitive};
use crate::tuning::TRIANGLES_BEYOND_CACHES;
use photosite_core::math::Real;
use photosite_simd::prefetch;

/// Corner indices into the vertex tables, and the mesh that the triangle belongs to.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Indices into [`Geometry::positions`].
    pub corners: [u32; 3],
    /// Index into [`Geometry::meshes`].
    pub mesh: u32,
}

/// Data that the triangles of a mesh have in common.
#[derive(Clone, Copy, Debug)]
pub struct MeshRange {
    /// Handle of the material.
    pub material: u32,
    /// Number of primitives (triangles and quadrics) before those of the mesh.
    pub first_primitive: u32,
    /// Handle of the first triangle of the mesh.
    pub first_triangle: u32,
    /// Number of triangles of the mesh.
    pub triangle_count: u32,
    /// Handle of the light of the first primitive, where the material emits; those of the others follow.
    pub first_light: Option<u32>,
    /// Number to subtract from a corner index to index [`Geometry::normals`]; `None` for flat shading.
    pub normals_from: Option<u32>,
    /// Number to subtract from a corner index to index [`Geometry::tangents`]; `None` without tangents.
    pub tangents_from: Option<u32>,
    /// Number to subtract from a corner index to index each set of [`Geometry::uvs`]; `None` without the set.
    pub uvs_from: [Option<u32>; 2],
    /// Number to subtract from a corner index to index [`Geometry::colours`]; `None` without colours.
    pub colours_from: Option<u32>,
    /// Index into [`Geometry::deformations`], where the mesh changes its shape in the time of the image.
    pub deformation: Option<u32>,
    /// Index into [`Geometry::quadrics`], of a mesh that is a quadric and has no triangles.
    pub quadric: Option<u32>,
}

impl MeshRange {
    /// Whether the mesh consists of triangles that keep their shape, without tangents.
    pub(crate) fn is_plain(&self) -> bool {
        self.tangents_from.is_none() && self.deformation.is_none() && self.quadric.is_none()
    }
}

/// The shapes that a mesh goes through, at evenly spaced times from 0 to 1. Between two of them its corners move on
/// straight lines.
#[derive(Clone, Debug)]
pub struct Deformation {
    /// Index of the mesh's first corner in [`Geometry::positions`], which holds the first shape too.
    pub first_corner: u32,
    /// Number of corners of a shape.
    pub corner_count: u32,
    /// Corners of all shapes, one shape after the other, m.
    pub positions: Vec<Vec3>,
    /// Unit shading normals in the same order, where the mesh has any.
    pub normals: Vec<Vec3>,
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
    /// Vertex colours, linear RGBA.
    pub colours: Vec<Vec4>,
    /// Triangles of all meshes.
    pub triangles: Vec<Triangle>,
    /// Quadrics, in world space.
    pub quadrics: Vec<PlacedQuadric>,
    /// Meshes of the triangles and quadrics.
    pub meshes: Vec<MeshRange>,
    /// Meshes that change their shape.
    pub deformations: Vec<Deformation>,
}

impl Geometry {
    /// Corner positions of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].corners.map(|corner| self.positions[corner as usize])
    }

    /// Whether there are more triangles than the caches have room for, so that it is worth asking the memory for some
    /// ahead of time.
    pub(crate) fn exceeds_caches(&self) -> bool {
        self.triangles.len() > TRIANGLES_BEYOND_CACHES
    }

    /// Asks the memory for what [`Self::prefetch_corners`] needs.
    #[inline]
    pub(crate) fn prefetch_primitive(&self, primitive: Primitive) {
        match primitive {
            Primitive::Triangle(triangle) => prefetch(&self.triangles[triangle as usize]),
            Primitive::Quadric(quadric) => prefetch(&self.quadrics[quadric as usize]),
        }
    }

    /// Asks the memory for the corners of a triangle.
    #[inline]
    pub(crate) fn prefetch_corners(&self, primitive: Primitive) {
        let Primitive::Triangle(triangle) = primitive else { return };
        for corner in self.triangles[triangle as usize].corners {
            prefetch(&self.positions[corner as usize]);
        }
    }

    /// Index of the mesh of a primitive.
    #[inline]
    pub fn mesh_of(&self, primitive: Primitive) -> u32 {
        match primitive {
            Primitive::Triangle(triangle) => self.triangles[triangle as usize].mesh,
            Primitive::Quadric(quadric) => self.quadrics[quadric as usize].mesh,
        }
    }

    /// The number of a primitive in the order in which meshes were added: another one for each, of whatever kind.
    #[inline]
    pub(crate) fn number(&self, primitive: Primitive) -> u32 {
        let mesh = &self.meshes[self.mesh_of(primitive) as usize];
        match primitive {
            Primitive::Triangle(triangle) => mesh.first_primitive + (triangle - mesh.first_triangle),
            Primitive::Quadric(_) => mesh.first_primitive,
        }
    }

    /// Corner positions of a triangle at a time from 0 to 1.
    #[inline]
    pub fn corners_at(&self, triangle: u32, time: f32) -> [Vec3; 3] {
        let triangle = &self.triangles[triangle as usize];
        self.corners_of(triangle, &self.meshes[triangle.mesh as usize], time)
    }

    /// Corners of a triangle at a time, both in double precision.
    pub(crate) fn exact_corners_at(&self, triangle: u32, time: f64) -> [DVec3; 3] {
        let triangle = &self.triangles[triangle as usize];
        let Some(deformation) = self.meshes[triangle.mesh as usize].deformation else {
            return triangle.corners.map(|corner| self.positions[corner as usize].as_dvec3());
        };
        let deformation = &self.deformations[deformation as usize];
        let along = time * (deformation.shape_count() - 1) as f64;
        let shape = (along as usize).min(deformation.shape_count() - 2);
        let [a, b] = [shape, shape + 1].map(|shape| deformation.corners(shape, triangle).map(|p| p.as_dvec3()));
        std::array::from_fn(|i| a[i].lerp(b[i], along - shape as f64))
    }

    /// Corner positions of a triangle of `mesh` at a time from 0 to 1.
    #[inline]
    pub(crate) fn corners_of(&self, triangle: &Triangle, mesh: &MeshRange, time: f32) -> [Vec3; 3] {
        let corners = triangle.corners;
        match mesh.deformation {
            None => corners.map(|corner| self.positions[corner as usize]),
            Some(deformation) => {
                let deformation = &self.deformations[deformation as usize];
                let (shape, part) = deformation.shape_at(time);
                corners.map(|corner| deformation.between(&deformation.positions, shape, part, corner))
            }
        }
    }

    /// Corner positions of a triangle in a shape of its mesh, of which most have one.
    pub(crate) fn corners_in(&self, triangle: u32, shape: usize) -> [Vec3; 3] {
        let triangle = &self.triangles[triangle as usize];
        match self.meshes[triangle.mesh as usize].deformation {
            None => triangle.corners.map(|corner| self.positions[corner as usize]),
            Some(deformation) => self.deformations[deformation as usize].corners(shape, triangle),
        }
    }

    /// Number of shapes of a triangle.
    pub(crate) fn shape_count(&self, triangle: u32) -> usize {
        let mesh = &self.meshes[self.triangles[triangle as usize].mesh as usize];
        mesh.deformation.map_or(1, |deformation| self.deformations[deformation as usize].shape_count())
    }

    /// Corner positions of a triangle in each of its shapes, between which its corners move on straight lines.
    pub(crate) fn shapes(&self, triangle: u32) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        (0..self.shape_count(triangle)).map(move |shape| self.corners_in(triangle, shape))
    }

    /// Shading normals at the corners of a triangle of that mesh, not quite of unit length, where it has any.
    #[inline]
    pub(crate) fn corner_normals(&self, triangle: &Triangle, mesh: &MeshRange, time: f32) -> Option<[Vec3; 3]> {
        let from = mesh.normals_from?;
        Some(match mesh.deformation {
            None => triangle.corners.map(|corner| self.normals[(corner - from) as usize]),
            Some(deformation) => {
                let deformation = &self.deformations[deformation as usize];
                let (shape, part) = deformation.shape_at(time);
                triangle.corners.map(|corner| deformation.between(&deformation.normals, shape, part, corner))
            }
        })
    }

    /// UV coordinates of a set at a point of a primitive, where its mesh has that set. Quadrics have the same ones in
    /// all sets.
    #[inline]
    pub fn uv(&self, primitive: Primitive, uv: [f32; 2], set: usize) -> Vec2 {
        match primitive {
            Primitive::Triangle(triangle) => {
                let triangle = &self.triangles[triangle as usize];
                let uvs = &self.uvs[set];
                match self.meshes[triangle.mesh as usize].uvs_from[set] {
                    Some(from) => interpolate(triangle.corners.map(|c| uvs[(c - from) as usize]), uv),
                    None => Vec2::ZERO,
                }
            }
            Primitive::Quadric(quadric) => self.quadrics[quadric as usize].quadric.texture_coordinates(uv),
        }
    }

    /// Linear RGBA at a point of a primitive, where its mesh has colours.
    #[inline]
    pub fn colour(&self, primitive: Primitive, uv: [f32; 2]) -> Option<Vec4> {
        let triangle = &self.triangles[primitive.triangle()? as usize];
        let from = self.meshes[triangle.mesh as usize].colours_from?;
        Some(interpolate(triangle.corners.map(|c| self.colours[(c - from) as usize]), uv))
    }
}

impl Deformation {
    /// Number of shapes.
    pub fn shape_count(&self) -> usize {
        self.positions.len() / self.corner_count as usize
    }

    /// Corner positions of a shape.
    pub(super) fn corners(&self, shape: usize, triangle: &Triangle) -> [Vec3; 3] {
        triangle.corners.map(|corner| self.positions[self.index(shape, corner)])
    }

    #[inline]
    fn shape_at(&self, time: f32) -> (usize, f32) {
        segment(time, self.shape_count() - 1)
    }

    #[inline]
    fn index(&self, shape: usize, corner: u32) -> usize {
        shape * self.corner_count as usize + (corner - self.first_corner) as usize
    }

    #[inline]
    fn between(&self, values: &[Vec3], shape: usize, part: f32, corner: u32) -> Vec3 {
        let [a, b] = [shape, shape + 1].map(|shape| values[self.index(shape, corner)]);
        a * (1.0 - part) + b * part
    }
}

/// Index of the part that `time` falls into, of `count` equal parts of the time from 0 to 1, and its position in it,
/// 0–1.
#[inline]
pub(crate) fn segment(time: f32, count: usize) -> (usize, f32) {
    let along = time * count as f32;
    let index = (along as usize).min(count - 1);
    (index, along - index as f32)
}

/// Linear interpolation over a triangle; `[b1, b2]` are the weights of the second and third corner.
#[inline(always)]
pub(crate) fn interpolate<R, T>([a, b, c]: [T; 3], [b1, b2]: [R; 2]) -> T
where
    R: Real,
    T: std::ops::Mul<R, Output = T> + std::ops::Add<Output = T>,
{
    a * (b1.broadcast(1.0) - b1 - b2) + b * b1 + c * b2
}
