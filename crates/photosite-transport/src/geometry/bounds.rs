//! Boxes along the axes.

use glam::Vec3;

/// A box, lower and upper corner.
pub(super) type Bounds = (Vec3, Vec3);

/// A box that contains nothing.
pub(super) const NOTHING: Bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);

/// The box of both.
pub(super) fn union(a: Bounds, b: Bounds) -> Bounds {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Half the area of a box, or 0 for [`NOTHING`].
pub(super) fn half_area((low, high): Bounds) -> f32 {
    let d = (high - low).max(Vec3::ZERO);
    d.x * d.y + d.y * d.z + d.z * d.x
}
