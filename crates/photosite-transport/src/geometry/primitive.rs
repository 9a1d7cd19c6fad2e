//! The kinds of primitives that rays meet.

/// A primitive of a [`Geometry`](super::Geometry).
///
/// A further kind takes an arm here, a table in the geometry, and a kind of leaf in the hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Primitive {
    /// Index into [`Geometry::triangles`](super::Geometry::triangles).
    Triangle(u32),
    /// Index into [`Geometry::quadrics`](super::Geometry::quadrics).
    Quadric(u32),
}

impl Primitive {
    /// The index of a triangle.
    #[inline]
    pub fn triangle(self) -> Option<u32> {
        match self {
            Self::Triangle(triangle) => Some(triangle),
            Self::Quadric(_) => None,
        }
    }
}
