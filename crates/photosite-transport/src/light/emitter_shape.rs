//! Points on a shape that emits, as they are seen from other points, with their densities.

use glam::Vec3;

use crate::geometry::QuadricPoint;
use photosite_core::math::{Area, Cone, Pdf, SolidAngle};

/// A shape whose points can be sampled, with a front and a back.
pub(crate) trait EmitterShape {
    /// Area of the shape, m².
    fn area(&self) -> f32;

    /// A point spread evenly over it, by two numbers in [0, 1).
    fn sample_area(&self, u: [f32; 2]) -> EmitterPoint;

    /// Directions of its normals.
    fn normals(&self) -> Cone;

    /// The largest area that its front shows in any direction, m².
    #[inline]
    fn widest(&self) -> f32 {
        self.area()
    }

    /// A point as it is seen from another one; `None` where light sampling leaves the shape to BSDF sampling. By default
    /// spread evenly over the shape.
    #[inline]
    fn sample(&self, from: Vec3, u: [f32; 2]) -> Option<SeenPoint> {
        Some(self.sample_area(u).seen_from(from, Pdf::new(1.0 / self.area())))
    }

    /// Density with which [`sample`](Self::sample) gives the point at `distance` (m) from another one that its normal
    /// leans towards with the cosine `cos`, of either sign.
    #[inline]
    fn pdf(&self, _from: Vec3, distance: f32, cos: f32) -> Pdf<SolidAngle> {
        Pdf::<Area>::new(1.0 / self.area()).to_solid_angle(distance * distance, cos.abs())
    }
}

/// A point of a shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EmitterPoint {
    /// Position, m.
    pub(crate) position: Vec3,
    /// Bound on the rounding error of the position, per axis, m.
    pub(crate) error: Vec3,
    /// Unit normal of the front.
    pub(crate) normal: Vec3,
    /// Parameters of the point on the primitive, as a [`Hit`](crate::geometry::Hit) tells it.
    pub(crate) parameters: [f32; 2],
}

/// A point of a shape as it is seen from another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenPoint {
    /// Point on the shape.
    pub(crate) point: EmitterPoint,
    /// Unit vector towards it.
    pub(crate) wi: Vec3,
    /// Cosine to the normal, positive where the front is seen.
    pub(crate) cos: f32,
    /// Density of the direction.
    pub(crate) pdf: Pdf<SolidAngle>,
}

impl EmitterPoint {
    /// A point of a quadric with its parameters.
    #[inline]
    pub(super) fn of_quadric(QuadricPoint { position, error, normal, .. }: QuadricPoint, parameters: [f32; 2]) -> Self {
        Self { position, error, normal, parameters }
    }

    /// Point as it is seen from `from`, sampled with a density per area.
    #[inline]
    pub(super) fn seen_from(self, from: Vec3, pdf: Pdf<Area>) -> SeenPoint {
        let towards = self.position - from;
        let distance_squared = towards.length_squared();
        let wi = towards / distance_squared.sqrt();
        let cos = -self.normal.dot(wi);
        SeenPoint { point: self, wi, cos, pdf: pdf.to_solid_angle(distance_squared, cos.abs()) }
    }
}
