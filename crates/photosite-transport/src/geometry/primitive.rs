//! The kinds of primitives that rays meet.

use std::ops::Range;

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
    /// Index of the triangle; `None` for a quadric.
    #[inline]
    pub fn triangle(self) -> Option<u32> {
        match self {
            Self::Triangle(triangle) => Some(triangle),
            Self::Quadric(_) => None,
        }
    }

    /// A number for [`Ray::to`](super::Ray::to): triangles count up from 0, quadrics down from [`Facet::NO_TRIANGLE`].
    #[inline]
    pub(crate) fn target(self) -> u32 {
        match self {
            Self::Triangle(triangle) => triangle,
            Self::Quadric(quadric) => Facet::NO_TRIANGLE - 1 - quadric,
        }
    }
}

/// Facet: a triangle of an instance, as the surface that a ray leaves: it is flat, so that the ray does not meet it
/// again. Quadrics are curved, and none of them is a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facet {
    instance: u32,
    triangle: u32,
}

impl Facet {
    /// Index that stands for no triangle.
    pub const NO_TRIANGLE: u32 = u32::MAX;
    /// Absence of a triangle, for a ray that begins elsewhere.
    pub const NONE: Self = Self { instance: 0, triangle: Self::NO_TRIANGLE };

    /// The triangle that a primitive of an instance is.
    #[inline]
    pub fn of(instance: u32, primitive: Primitive) -> Self {
        primitive.triangle().map_or(Self::NONE, |triangle| Self { instance, triangle })
    }

    /// Index of the triangle in an instance; that of no triangle where it belongs to another one.
    #[inline(always)]
    pub(super) fn within(self, instance: u32) -> u32 {
        if self.instance == instance { self.triangle } else { Self::NO_TRIANGLE }
    }
}

/// The primitives of a bottom-level hierarchy.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrimitiveRange {
    /// Indices into [`Geometry::triangles`](super::Geometry::triangles).
    pub triangles: Range<u32>,
    /// Indices into [`Geometry::quadrics`](super::Geometry::quadrics), which must be in world space.
    pub quadrics: Range<u32>,
}

impl From<Range<u32>> for PrimitiveRange {
    /// Makes a range of triangles alone.
    fn from(triangles: Range<u32>) -> Self {
        Self { triangles, quadrics: 0..0 }
    }
}

impl PrimitiveRange {
    /// The primitives.
    pub(crate) fn primitives(&self) -> impl Iterator<Item = Primitive> + use<> {
        self.triangles.clone().map(Primitive::Triangle).chain(self.quadrics.clone().map(Primitive::Quadric))
    }

    /// Number of primitives.
    pub(crate) fn len(&self) -> usize {
        self.triangles.len() + self.quadrics.len()
    }
}
