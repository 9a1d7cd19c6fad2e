//! The triangle of a light, with what is asked of it for each point that looks at it.

use glam::Vec3;

/// A triangle where it is at a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    corner: Vec3,
    /// From that corner to the other two.
    edges: [Vec3; 2],
    /// Unit vector.
    pub(super) normal: Vec3,
    /// Twice its area, m².
    pub(super) double_area: f32,
}

impl Facet {
    /// `None` without area.
    #[inline]
    pub(super) fn new([a, b, c]: [Vec3; 3]) -> Option<Self> {
        let edges = [b - a, c - a];
        let across = edges[0].cross(edges[1]);
        let double_area = across.length();
        (double_area > 0.0).then(|| Self { corner: a, edges, normal: across / double_area, double_area })
    }

    /// The point with these weights of the second and the third corner.
    #[inline]
    pub(super) fn point(&self, [b1, b2]: [f32; 2]) -> Vec3 {
        self.corner + self.edges[0] * b1 + self.edges[1] * b2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_triangle_has_half_the_area_of_its_rectangle() {
        let corner = Vec3::new(1.0, 2.0, 3.0);
        let facet = Facet::new([corner, corner + 3.0 * Vec3::X, corner + 4.0 * Vec3::Y]).expect("an area");
        assert_eq!((facet.double_area, facet.normal), (12.0, Vec3::Z));
        assert_eq!(facet.point([0.0, 0.0]), corner);
        assert_eq!(facet.point([1.0, 0.0]), Vec3::new(4.0, 2.0, 3.0));
        assert_eq!(facet.point([0.25, 0.5]), Vec3::new(1.75, 4.0, 3.0));
    }

    #[test]
    fn corners_on_a_line_make_none() {
        assert!(Facet::new([Vec3::ZERO, Vec3::X, 3.0 * Vec3::X]).is_none());
        assert!(Facet::new([Vec3::ONE; 3]).is_none());
    }
}
