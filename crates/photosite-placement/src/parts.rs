//! Convex parts of a shape that is not convex itself, for the rigid-body engine.

use parry3d_f64::math::Vector;
use parry3d_f64::shape::TriMesh;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};

use crate::hull::Hull;

/// Convex parts of a mesh with that hull, by V-HACD (Mamou, "Volumetric Hierarchical Approximate Convex Decomposition",
/// Game Engine Gems 3, 2016). Hulls are those of the triangles clipped to the voxels, so that convex regions keep their
/// exact surface.
pub(crate) fn parts(mesh: &TriMesh, hull: &Hull) -> Vec<Hull> {
    let (points, triangles) = (mesh.vertices(), mesh.indices());
    let parameters = VHACDParameters { resolution: 48, concavity: 0.01, ..VHACDParameters::default() };
    let decomposed = VHACD::decompose(&parameters, points, triangles, true);
    let hulls: Vec<Hull> = decomposed
        .compute_primitive_intersections(points, triangles)
        .iter()
        .filter_map(|points: &Vec<Vector>| Hull::of(points))
        .collect();
    if hulls.is_empty() { vec![hull.clone()] } else { hulls }
}
