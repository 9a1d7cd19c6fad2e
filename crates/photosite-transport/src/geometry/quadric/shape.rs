//! Common interface of the shapes of quadrics: points and a box.

use glam::{DVec3, Vec3};

use crate::geometry::bounds::Bounds;
use photosite_core::math::float::gamma;

/// A point of a quadric.
pub(crate) struct QuadricPoint {
    /// Position, m.
    pub(crate) position: Vec3,
    /// Bound on the rounding error of the position, per axis, m.
    pub(crate) error: Vec3,
    /// Unit normal of the front.
    pub(crate) normal: Vec3,
    /// The direction of growing u of the [texture coordinates](super::Quadric::texture_coordinates); of any length.
    pub(crate) tangent: Vec3,
}

/// The box that reaches so far from a centre along each axis, in single precision and widened by its rounding.
pub(super) fn box_around(centre: DVec3, reach: DVec3) -> Bounds {
    let error = (centre.abs() + reach).as_vec3() * gamma(8);
    ((centre - reach).as_vec3() - error, (centre + reach).as_vec3() + error)
}
