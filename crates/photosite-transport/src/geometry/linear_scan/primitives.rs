//! The primitives of a scene that is scanned.

use glam::Vec3;

use crate::geometry::bounds::Bounds;
use crate::geometry::near_hit::is_slender;
use crate::geometry::{Geometry, Primitive, PrimitiveRange, Quadric};
use crate::tuning::LINEAR_SCAN_MAX;

/// Table of all primitives of a small scene.
#[derive(Clone, Debug)]
pub(in crate::geometry) struct LinearScan {
    /// Vertices, each once.
    pub(super) vertices: Vec<Vec3>,
    pub(super) triangles: Vec<PackedTriangle>,
    /// Quadrics with their indices in the geometry.
    pub(super) quadrics: Vec<(u32, Quadric)>,
    pub(super) bounds: Bounds,
}

/// A triangle by the indices of its vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedTriangle {
    pub(super) vertices: [u8; 3],
    /// Index in the geometry.
    pub(super) id: u32,
    /// Whether the triangle [`is_slender`].
    pub(super) is_slender: bool,
}

impl LinearScan {
    /// Lays out a range of primitives, all within `bounds`; `None` where they are too many.
    pub(in crate::geometry) fn new(geometry: &Geometry, range: &PrimitiveRange, bounds: Bounds) -> Option<Self> {
        if range.len() > LINEAR_SCAN_MAX {
            return None;
        }
        let mut scan = Self { vertices: Vec::new(), triangles: Vec::new(), quadrics: Vec::new(), bounds };
        let quadric = |id: u32| (id, geometry.quadrics[id as usize].quadric);
        scan.quadrics.extend(range.quadrics.clone().map(quadric));
        for id in range.triangles.clone() {
            let mut index = |corner: Vec3| {
                let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
                let known = scan.vertices.iter().position(|vertex| bits(vertex) == bits(&corner));
                known.unwrap_or_else(|| {
                    scan.vertices.push(corner);
                    scan.vertices.len() - 1
                }) as u8
            };
            let corners = geometry.corners(id);
            let vertices = corners.map(&mut index);
            scan.triangles.push(PackedTriangle { vertices, id, is_slender: is_slender(&corners) });
        }
        (scan.vertices.len() <= LINEAR_SCAN_MAX).then_some(scan)
    }

    /// Index of a triangle of the geometry, which has them in this order; beyond all where it is none of these.
    #[inline(always)]
    pub(super) fn index_of(&self, id: u32) -> u32 {
        id.wrapping_sub(self.triangles.first().map_or(0, |first| first.id))
    }

    /// Index in the scan of what a ray ends at ([`Primitive::target`]); beyond all where it is none of these.
    #[inline]
    pub(super) fn index_of_target(&self, target: u32) -> u32 {
        let number = |(first, _): &(u32, Quadric)| Primitive::Quadric(*first).target().wrapping_sub(target);
        match self.quadrics.first().map(number).filter(|&number| number < self.quadrics.len() as u32) {
            Some(number) => self.triangles.len() as u32 + number,
            None => Some(self.index_of(target)).filter(|&i| i < self.triangles.len() as u32).unwrap_or(u32::MAX),
        }
    }
}
