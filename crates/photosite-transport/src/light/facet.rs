//! The triangle of a light, with what is asked of it for each point that looks at it.

use glam::Vec3;

use photosite_core::math::pdf::to_solid_angle;
use photosite_core::math::{Real, Vector};
use photosite_simd::{Simd, Vectors};

/// A triangle where it is at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet<R = f32> {
    corner: Vector<R>,
    /// From that corner to the other two.
    edges: [Vector<R>; 2],
    /// Unit vector.
    pub(crate) normal: Vector<R>,
    /// Twice its area, m².
    pub(super) double_area: R,
}

/// A point of a facet, seen from another point.
pub(crate) struct Sight<R> {
    /// Metres.
    pub(crate) position: Vector<R>,
    /// Unit vector towards it.
    pub(crate) wi: Vector<R>,
    /// Positive where the front is seen.
    pub(crate) cos: R,
    /// Of points spread evenly over the facet, sr⁻¹ where they are seen from.
    pub(crate) density: R,
}

impl Facet {
    /// `None` without area.
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

    /// Its unit normal.
    pub(crate) fn normal(&self) -> Vec3 {
        self.normal.into()
    }
}

impl<R: Real> Facet<R> {
    /// The point with these weights of the second and the third corner.
    #[inline(always)]
    pub(super) fn point(&self, [b1, b2]: [R; 2]) -> Vector<R> {
        self.corner + self.edges[0] * b1 + self.edges[1] * b2
    }

    /// The same as it is seen from another point.
    #[inline(always)]
    pub(crate) fn sight(&self, barycentric: [R; 2], from: Vector<R>) -> Sight<R> {
        let position = self.point(barycentric);
        let towards = position - from;
        let distance_squared = towards.dot(towards);
        let wi = towards.over(distance_squared.sqrt());
        let cos = -self.normal.dot(wi);
        let density = to_solid_angle(self.double_area.broadcast(2.0) / self.double_area, distance_squared, cos.abs());
        Sight { position, wi, cos, density }
    }
}

/// Eight facets in memory.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Facets {
    corner: Vectors,
    edges: [Vectors; 2],
    normal: Vectors,
    double_area: [f32; 8],
}

impl Facets {
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, facet: &Facet) {
        self.corner.set(lane, facet.corner.into());
        self.edges[0].set(lane, facet.edges[0].into());
        self.edges[1].set(lane, facet.edges[1].into());
        self.normal.set(lane, facet.normal.into());
        self.double_area[lane] = facet.double_area;
    }

    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S) -> Facet<S::Lanes> {
        Facet {
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
        let facet = Facet::new([corner, corner + 3.0 * Vec3::X, corner + 4.0 * Vec3::Y]).expect("an area");
        assert_eq!((facet.double_area, facet.normal()), (12.0, Vec3::Z));
        assert_eq!(Vec3::from(facet.point([0.0, 0.0])), corner);
        assert_eq!(Vec3::from(facet.point([1.0, 0.0])), Vec3::new(4.0, 2.0, 3.0));
        assert_eq!(Vec3::from(facet.point([0.25, 0.5])), Vec3::new(1.75, 4.0, 3.0));
    }

    #[test]
    fn corners_on_a_line_make_none() {
        assert!(Facet::new([Vec3::ZERO, Vec3::X, 3.0 * Vec3::X]).is_none());
        assert!(Facet::new([Vec3::ONE; 3]).is_none());
    }
}
