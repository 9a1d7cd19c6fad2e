//! Surfaces that objects are put on: points uniform over their upward faces, and objects lowered onto them.

use glam::DVec3;
use photosite_core::math::philox::Philox;
use rand::RngExt;

use crate::body::{Body, distance};
use crate::pose::{Pose, point};

/// Least vertical component of the normal of an upward face, less steep than 60°.
const UPWARD: f64 = 0.5;
/// Largest gap between a lowered object and what it touches, m.
pub(crate) const TOUCH_M: f64 = 5e-7;

/// Upward faces of a fixed object.
pub(crate) struct Surface<'a> {
    body: &'a Body,
    pose: &'a Pose,
    triangles: Vec<[DVec3; 3]>,
    /// Cumulative areas of the triangles.
    areas: Vec<f64>,
}

impl<'a> Surface<'a> {
    /// Upward faces of an object; `None` where there are none.
    pub(crate) fn new(body: &'a Body, pose: &'a Pose) -> Option<Self> {
        let (mut triangles, mut areas, mut sum) = (Vec::new(), Vec::new(), 0.0);
        for triangle in body.mesh.triangles() {
            let corners = [triangle.a, triangle.b, triangle.c].map(|p| pose.point(point(p)));
            let twice = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let area = twice.length();
            // What is not closed has no outside: both sides count.
            let up = if body.shape.is_closed { twice.y } else { twice.y.abs() };
            if area > 0.0 && up >= UPWARD * area {
                sum += area;
                triangles.push(corners);
                areas.push(sum);
            }
        }
        (sum > 0.0).then_some(Self { body, pose, triangles, areas })
    }

    /// A random point, uniform by area.
    pub(crate) fn draw(&self, random: &mut Philox) -> DVec3 {
        let total = self.areas.last().copied().unwrap_or_default();
        let at = random.random::<f64>() * total;
        let [a, b, c] = self.triangles[self.areas.partition_point(|sum| *sum <= at).min(self.triangles.len() - 1)];
        let [u, v] = random.random::<[f64; 2]>();
        let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
        a + (b - a) * u + (c - a) * v
    }

    /// Pose of an object with this rotation, its centre of mass over a point of the surface, lowered until it touches;
    /// `None` where there is no room above the point.
    pub(crate) fn lowered(&self, body: &Body, rotation: glam::DQuat, at: DVec3) -> Option<Pose> {
        let mut pose = body.centred(rotation, at);
        pose.position.y += at.y - body.lowest(&pose);
        // From a little above, so that nothing that overhangs is in the way; on rough ground from higher.
        let mut lift = 0.01 * body.radius;
        let mut gap = 0.0;
        let start = pose.position.y;
        while gap == 0.0 && lift < 4.0 * body.radius {
            pose.position.y = start + lift;
            gap = self.gap(body, &pose);
            lift *= 2.0;
        }
        if gap == 0.0 {
            return None;
        }
        // Moved down by its distance it meets nothing.
        for _ in 0..200 {
            if gap <= TOUCH_M {
                return Some(pose);
            }
            pose.position.y -= gap - TOUCH_M / 2.0;
            gap = self.gap(body, &pose);
            if gap == f64::INFINITY || gap == 0.0 {
                return None;
            }
        }
        None
    }

    /// Whether the surface supports all the points on which an object stands.
    pub(crate) fn carries(&self, body: &Body, pose: &Pose) -> bool {
        let lowest = body.lowest(pose);
        let feet = body.mesh.vertices().iter().map(|p| pose.point(point(*p))).filter(|p| p.y - lowest <= 2.0 * TOUCH_M);
        let own = |p: DVec3| self.pose.rotation.inverse() * (p - self.pose.position);
        let is_on = |p: DVec3| {
            use parry3d_f64::query::PointQuery;
            let p = crate::pose::vector(own(p));
            let near = self.body.mesh.project_local_point(p, false).point;
            near.distance(p) <= 4.0 * TOUCH_M
        };
        feet.into_iter().all(is_on)
    }

    fn gap(&self, body: &Body, pose: &Pose) -> f64 {
        distance((body, pose), (self.body, self.pose), 8.0 * body.radius)
    }
}
