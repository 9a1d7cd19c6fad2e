//! Convex parts of a shape that is not convex itself, for the rigid-body engine.

use parry3d_f64::math::Vector;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};

use crate::shape::{Hull, Shape};

/// Convex parts by V-HACD (Mamou, "Volumetric Hierarchical Approximate Convex Decomposition", Game Engine Gems 3, 2016).
/// What triangles leave of the voxels is hulled itself, so that convex regions keep their exact surface.
pub(crate) fn parts(shape: &Shape) -> Vec<Hull> {
    let (points, triangles) = (shape.mesh.vertices(), shape.mesh.indices());
    let parameters = VHACDParameters { resolution: 48, concavity: 0.01, ..VHACDParameters::default() };
    let decomposed = VHACD::decompose(&parameters, points, triangles, true);
    let hulls: Vec<Hull> = decomposed
        .compute_primitive_intersections(points, triangles)
        .iter()
        .filter_map(|points: &Vec<Vector>| Hull::of(points))
        .collect();
    if hulls.is_empty() { vec![shape.hull.clone()] } else { hulls }
}
