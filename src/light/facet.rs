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
