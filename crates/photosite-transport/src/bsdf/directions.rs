//! Directions in the local shading frame: on which side of the surface they are, and where that is no longer known.

use glam::Vec3;

/// Directions with a smaller cosine count as lying in the surface, where nothing is scattered: on which side they are
/// is no longer known, a unit vector being rounded to 6e-8.
pub(crate) const GRAZING: f32 = 1e-7;

/// Smallest cosine between a shading normal and the viewer: normals below it are bent towards the viewer
/// (`scene::shading`).
pub(crate) const MIN_SHADING_COSINE: f32 = 1e-3;

/// Cosine below which a surface counts as seen edge-on, since its shading normal may have been bent for this viewer
/// alone.
pub(crate) const EDGE_ON_COSINE: f32 = 2.0 * MIN_SHADING_COSINE;

/// Whether a direction lies in the plane of the surface.
#[inline]
pub(super) fn is_grazing(w: Vec3) -> bool {
    w.z.abs() <= GRAZING
}

/// Whether a direction is above the surface.
#[inline]
pub(super) fn is_above(w: Vec3) -> bool {
    w.z > GRAZING
}

/// The direction on the other side of the surface.
#[inline]
pub(super) fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}
