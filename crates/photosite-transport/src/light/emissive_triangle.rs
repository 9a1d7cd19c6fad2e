//! The triangle of an area light, with what sampling it needs.

use glam::Vec3;

use super::emitter_shape::{EmitterPoint, EmitterShape, SeenPoint};
use crate::geometry::{Word, word};
use photosite_core::math::float::gamma;
use photosite_core::math::pdf::to_solid_angle;
use photosite_core::math::{Cone, Pdf, Real, Vector, warp};
use photosite_simd::{Simd, Vectors};

/// A triangle where it is at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EmissiveTriangle<R = f32> {
    corner: Vector<R>,
    /// Vectors from that corner to the other two, m.
    edges: [Vector<R>; 2],
    /// Unit vector.
    pub(crate) normal: Vector<R>,
    /// Twice the area of the triangle, m².
    double_area: R,
}

/// A point of an emissive triangle, seen from another point.
pub(crate) struct VisiblePoint<R> {
    /// Position, m.
    pub(crate) position: Vector<R>,
    /// Unit vector towards it.
    pub(crate) wi: Vector<R>,
    /// Cosine to the normal, positive where the front is seen.
    pub(crate) cos: R,
    /// Density of points spread evenly over the triangle, sr⁻¹ at the point that they are seen from.
    pub(crate) density: R,
}

impl EmissiveTriangle {
    /// Prepares the triangle; `None` without area.
    #[inline]
    pub(super) fn new([a, b, c]: [Vec3; 3]) -> Option<Self> {
        let edges = [b - a, c - a];
        let across = edges[0].cross(edges[1]);
        let double_area = across.length();
        (double_area > 0.0).then(|| Self {
            corner: a.into(),
            edges: edges.map(Vector::from),
            normal: (across / double_area).into(),
            double_area,
        })
    }

    /// The triangle as plain data: a corner with twice the area, and two edges.
    pub(super) fn words(&self) -> [Word; 3] {
        let Self { corner, edges: [a, b], double_area, .. } = *self;
        [word(corner.into(), double_area.to_bits()), word(a.into(), 0), word(b.into(), 0)]
    }

    #[inline]
    fn emitter_point(&self, position: Vec3, parameters: [f32; 2]) -> EmitterPoint {
        // A few roundings lie between the corners and a point.
        EmitterPoint { position, error: position.abs() * gamma(8), normal: self.normal.into(), parameters }
    }
}

/// Points are spread evenly over it.
impl EmitterShape for EmissiveTriangle {
    #[inline]
    fn area(&self) -> f32 {
        0.5 * self.double_area
    }

    #[inline]
    fn sample_area(&self, u: [f32; 2]) -> EmitterPoint {
        let barycentric = warp::uniform_triangle(u);
        self.emitter_point(self.point(barycentric).into(), barycentric)
    }

    fn normals(&self) -> Cone {
        Cone::of(self.normal.into())
    }

    #[inline]
    fn sample(&self, from: Vec3, u: [f32; 2]) -> Option<SeenPoint> {
        let barycentric = warp::uniform_triangle(u);
        let VisiblePoint { position, wi, cos, density } = self.seen_from(barycentric, from.into());
        let point = self.emitter_point(position.into(), barycentric);
        Some(SeenPoint { point, wi: wi.into(), cos, pdf: Pdf::new(density) })
    }
}

impl<R: Real> EmissiveTriangle<R> {
    /// The point with these weights of the second and the third corner.
    #[inline(always)]
    fn point(&self, [b1, b2]: [R; 2]) -> Vector<R> {
        self.corner + self.edges[0] * b1 + self.edges[1] * b2
    }

    /// Point of the triangle as it is seen from another point.
    #[inline(always)]
    pub(crate) fn seen_from(&self, barycentric: [R; 2], from: Vector<R>) -> VisiblePoint<R> {
        let position = self.point(barycentric);
        let towards = position - from;
        let distance_squared = towards.dot(towards);
        let wi = towards.over(distance_squared.sqrt());
        let cos = -self.normal.dot(wi);
        let density = to_solid_angle(self.double_area.broadcast(2.0) / self.double_area, distance_squared, cos.abs());
        VisiblePoint { position, wi, cos, density }
    }
}

/// Eight static_triangles in memory.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EmissiveTriangles {
    corner: Vectors,
    edges: [Vectors; 2],
    normal: Vectors,
    double_area: [f32; 8],
}

impl EmissiveTriangles {
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, triangle: &EmissiveTriangle) {
        self.corner.set(lane, triangle.corner.into());
        self.edges[0].set(lane, triangle.edges[0].into());
        self.edges[1].set(lane, triangle.edges[1].into());
        self.normal.set(lane, triangle.normal.into());
        self.double_area[lane] = triangle.double_area;
    }

    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S) -> EmissiveTriangle<S::Lanes> {
        EmissiveTriangle {
            corner: self.corner.load(simd),
            edges: [self.edges[0].load(simd), self.edges[1].load(simd)],
            normal: self.normal.load(simd),
            double_area: simd.load(&self.double_area),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_triangle_has_half_the_area_of_its_rectangle() {
        let corner = Vec3::new(1.0, 2.0, 3.0);
        let triangle =
            EmissiveTriangle::new([corner, corner + 3.0 * Vec3::X, corner + 4.0 * Vec3::Y]).expect("an area");
        assert_eq!((triangle.area(), triangle.normals()), (6.0, Cone::of(Vec3::Z)));
        assert_eq!(Vec3::from(triangle.point([0.0, 0.0])), corner);
        assert_eq!(Vec3::from(triangle.point([1.0, 0.0])), Vec3::new(4.0, 2.0, 3.0));
        assert_eq!(Vec3::from(triangle.point([0.25, 0.5])), Vec3::new(1.75, 4.0, 3.0));
    }

    #[test]
    fn corners_on_a_line_make_none() {
        assert!(EmissiveTriangle::new([Vec3::ZERO, Vec3::X, 3.0 * Vec3::X]).is_none());
        assert!(EmissiveTriangle::new([Vec3::ONE; 3]).is_none());
    }
}
