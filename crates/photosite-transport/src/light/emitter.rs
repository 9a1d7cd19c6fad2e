//! Shapes that emit: triangles and quadrics.

mod cylinder;
mod disk;
mod sphere;
#[cfg(test)]
mod tests;

use glam::Vec3;

use super::emissive_triangle::EmissiveTriangle;
pub(crate) use super::emitter_shape::{EmitterPoint, EmitterShape, SeenPoint};
use crate::geometry::{Geometry, Primitive, Quadric};
use photosite_core::math::{Cone, Pdf, SolidAngle};

/// The shape of an area light at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Emitter {
    /// Flat, with three corners.
    Triangle(EmissiveTriangle),
    /// Quadric, exactly round.
    Quadric(Quadric),
}

/// Calls a method of [`EmitterShape`] on the shape of an emitter.
macro_rules! of_shape {
    ($emitter:expr, $shape:ident => $value:expr) => {
        match $emitter {
            Emitter::Triangle($shape) => $value,
            Emitter::Quadric(Quadric::Sphere($shape)) => $value,
            Emitter::Quadric(Quadric::Disk($shape)) => $value,
            Emitter::Quadric(Quadric::Cylinder($shape)) => $value,
        }
    };
}

impl Emitter {
    /// The shape of a primitive at a time; `None` where it has no area.
    #[inline]
    pub(crate) fn at(geometry: &Geometry, primitive: Primitive, time: f32) -> Option<Self> {
        match primitive {
            Primitive::Triangle(triangle) => {
                EmissiveTriangle::new(geometry.corners_at(triangle, time)).map(Self::Triangle)
            }
            Primitive::Quadric(quadric) => Some(Self::Quadric(geometry.quadrics[quadric as usize].quadric)),
        }
    }

    /// The shape of a primitive that keeps it; `None` of others, and where it has no area.
    pub(super) fn at_rest(geometry: &Geometry, primitive: Primitive) -> Option<Self> {
        let deforms = geometry.meshes[geometry.mesh_of(primitive) as usize].deformation.is_some();
        Self::at(geometry, primitive, 0.0).filter(|_| !deforms)
    }
}

impl EmitterShape for Emitter {
    #[inline]
    fn area(&self) -> f32 {
        of_shape!(self, shape => shape.area())
    }

    #[inline]
    fn sample_area(&self, u: [f32; 2]) -> EmitterPoint {
        of_shape!(self, shape => shape.sample_area(u))
    }

    fn normals(&self) -> Cone {
        of_shape!(self, shape => shape.normals())
    }

    fn widest(&self) -> f32 {
        of_shape!(self, shape => shape.widest())
    }

    #[inline]
    fn sample(&self, from: Vec3, u: [f32; 2]) -> Option<SeenPoint> {
        of_shape!(self, shape => shape.sample(from, u))
    }

    #[inline]
    fn pdf(&self, from: Vec3, distance: f32, cos: f32) -> Pdf<SolidAngle> {
        of_shape!(self, shape => shape.pdf(from, distance, cos))
    }
}
