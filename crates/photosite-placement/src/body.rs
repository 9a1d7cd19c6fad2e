//! Objects at their scale, and the exact test of whether two of them meet.

use std::sync::Arc;

use glam::DVec3;
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{self, ClosestPoints};
use parry3d_f64::shape::TriMesh;

use crate::pose::{Pose, point, vector};
use crate::resting::solid_angle;
use crate::shape::Shape;

/// An object at its scale.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) shape: Arc<Shape>,
    pub(crate) scale: f64,
    pub(crate) density: f64,
    /// Mesh at this scale.
    pub(crate) mesh: Arc<TriMesh>,
    /// Centre of mass, m.
    pub(crate) centre: DVec3,
    /// Radius of the bounding sphere about the centre of mass, m.
    pub(crate) radius: f64,
}

impl Body {
    pub(crate) fn new(shape: &Arc<Shape>, scale: f64, density: f64) -> Self {
        let mesh = match scale == 1.0 {
            true => shape.mesh.clone(),
            false => Arc::new(TriMesh::clone(&shape.mesh).scaled(Vector::splat(scale))),
        };
        let (centre, radius) = (shape.centre_of_mass() * scale, shape.radius() * scale);
        Self { shape: shape.clone(), scale, density, mesh, centre, radius }
    }

    /// Bounding box along the axes of the world.
    pub(crate) fn bounds(&self, pose: &Pose) -> Aabb {
        self.mesh.aabb(&pose.to_parry())
    }

    /// Lowest coordinate along the vertical, m.
    pub(crate) fn lowest(&self, pose: &Pose) -> f64 {
        self.heights(pose).fold(f64::INFINITY, f64::min)
    }

    /// Highest coordinate along the vertical, m.
    pub(crate) fn highest(&self, pose: &Pose) -> f64 {
        self.heights(pose).fold(f64::NEG_INFINITY, f64::max)
    }

    fn heights(&self, pose: &Pose) -> impl Iterator<Item = f64> {
        // The row of the rotation that makes heights.
        let up = pose.rotation.inverse() * DVec3::Y;
        self.mesh.vertices().iter().map(move |p| up.dot(point(*p)) + pose.position.y)
    }

    /// The pose with this rotation and the centre of mass at a point.
    pub(crate) fn centred(&self, rotation: glam::DQuat, centre: DVec3) -> Pose {
        Pose { rotation, position: centre - rotation * self.centre }
    }

    /// Whether a point in the object's own frame is inside, by the winding number (Jacobson, Kavan, Sorkine-Hornung,
    /// "Robust inside-outside segmentation using generalized winding numbers", 2013).
    fn encloses(&self, p: DVec3) -> bool {
        if !self.shape.is_closed || !self.mesh.local_aabb().contains_local_point(vector(p)) {
            return false;
        }
        let of = |t: parry3d_f64::shape::Triangle| solid_angle([t.a, t.b, t.c].map(|corner| point(corner) - p));
        let whole: f64 = self.mesh.triangles().map(of).sum();
        whole.abs() > std::f64::consts::TAU
    }
}

/// Distance of two objects, m, exactly by their triangles: 0 where they meet or one is inside the other, infinity where
/// the distance is more than `margin`.
pub(crate) fn distance((a, pose_a): (&Body, &Pose), (b, pose_b): (&Body, &Pose), margin: f64) -> f64 {
    if !a.bounds(pose_a).loosened(margin).intersects(&b.bounds(pose_b)) {
        return f64::INFINITY;
    }
    // The smaller one is the one that asks the other's tree for each of its triangles.
    let (few, many) = ((a, pose_a), (b, pose_b));
    let ((few, pose_few), (many, pose_many)) =
        if a.mesh.num_triangles() <= b.mesh.num_triangles() { (few, many) } else { (many, few) };
    let found = query::closest_points(&pose_few.to_parry(), &*few.mesh, &pose_many.to_parry(), &*many.mesh, margin);
    let distance = match found {
        Ok(ClosestPoints::WithinMargin(p, q)) => p.distance(q),
        Ok(ClosestPoints::Disjoint) => f64::INFINITY,
        // Meshes are always supported.
        Ok(ClosestPoints::Intersecting) | Err(_) => return 0.0,
    };
    let is_inside = |inner: &Body, pose: &Pose, outer: &Body, outer_pose: &Pose| {
        let own = |p: &DVec3| outer_pose.rotation.inverse() * (pose.point(*p * inner.scale) - outer_pose.position);
        inner.shape.pieces.iter().any(|p| outer.encloses(own(p)))
    };
    if is_inside(a, pose_a, b, pose_b) || is_inside(b, pose_b, a, pose_a) { 0.0 } else { distance }
}
