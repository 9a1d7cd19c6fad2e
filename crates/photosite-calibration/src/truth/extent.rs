//! Extent of an object: its box in its frame over the time of an image.
//!
//! In: instances with their meshes, as they go through the world, and the frame that goes along. Out: the least box of
//! the frame that holds all their vertices at all times, as the scene is [built](photosite_transport::scene::build) of
//! them: what keeps its shape goes on [`Motion`](photosite_transport::geometry::Motion)s, and the vertices of what does
//! not, or emits light, straight through the world from key to key.

use glam::{DAffine3, DVec3, Vec3};

use super::pose_path::{PosePath, lerp, segment};
use photosite_transport::scene::description::{InstanceDescription, MeshDescription, SceneDescription};

/// Parts between two keys that are looked at. Of the arc of an object that turns by 5° from key to key, as most of them
/// do at most, 4e-6 of the radius is left unseen.
const STEPS: usize = 16;

/// A box along the axes of a frame, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    pub(super) low: DVec3,
    pub(super) high: DVec3,
}

impl Extent {
    /// The extent of no point.
    pub(super) const NONE: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// The extent of all instances that make an object.
    pub(super) fn of_object(frame: &PosePath, instances: &[InstanceDescription], scene: &SceneDescription) -> Self {
        let mut all = Self::NONE;
        for instance in instances {
            let way = PosePath::new(instance.to_world, instance.later.iter().copied());
            for mesh in &scene.meshes[instance.meshes.clone()] {
                if mesh.later_shapes.is_empty() {
                    let shines = scene.materials.get(mesh.material).is_some_and(|material| material.emission.is_some());
                    all.add_rigid(frame, &way, shines, mesh);
                } else {
                    all.add_deforming(frame, &way, mesh);
                }
            }
        }
        all
    }

    fn add(&mut self, point: DVec3) {
        (self.low, self.high) = (self.low.min(point), self.high.max(point));
    }

    fn add_vertices(&mut self, to_frame: &DAffine3, vertices: &[Vec3]) {
        vertices.iter().for_each(|vertex| self.add(to_frame.transform_point3(vertex.as_dvec3())));
    }

    fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let larger = glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
            DVec3::select(larger, self.high, self.low)
        })
    }

    /// Adds a mesh that keeps its shape. Most of them stand still in the frame, and their vertices are gone through
    /// once.
    fn add_rigid(&mut self, frame: &PosePath, way: &PosePath, shines: bool, mesh: &MeshDescription) {
        let mut own = Self::NONE;
        own.add_vertices(&DAffine3::IDENTITY, &mesh.positions);
        let corners = own.corners();
        let apart = |a: &DAffine3, b: &DAffine3| {
            let of_corner = |corner: &DVec3| a.transform_point3(*corner).distance(b.transform_point3(*corner));
            corners.iter().map(of_corner).fold(0.0, f64::max)
        };
        let to_frame = |time: f64| {
            let to_world = if shines { way.straight_at(time) } else { way.at(time) };
            frame.at(time).inverse() * to_world
        };
        let mut last = to_frame(0.0);
        self.add_vertices(&last, &mesh.positions);
        // The precision of places that rays find.
        let near = f64::from(f32::EPSILON) * last.transform_vector3(corners[7] - corners[0]).length();
        let keys = frame.parts.max(way.parts);
        for key in 0..keys {
            let place = |part: f64| to_frame((key as f64 + part) / keys as f64);
            let [start, end] = [place(0.0), place(1.0)];
            let steps = (1..STEPS).map(|step| step as f64 / STEPS as f64);
            // Where it goes straight, both ends are enough.
            let is_bent = steps.clone().any(|part| apart(&place(part), &lerp(&start, &end, part)) > near);
            for place in steps.filter(|_| is_bent).map(place).chain([end]) {
                if apart(&place, &last) > near {
                    self.add_vertices(&place, &mesh.positions);
                    last = place;
                }
            }
        }
    }

    /// Adds a mesh that changes its shape. Its vertices go straight through the world from key to key.
    fn add_deforming(&mut self, frame: &PosePath, way: &PosePath, mesh: &MeshDescription) {
        let shapes: Vec<&Vec<Vec3>> =
            [&mesh.positions].into_iter().chain(mesh.later_shapes.iter().map(|shape| &shape.positions)).collect();
        let world_keys = way.parts.max(mesh.later_shapes.len());
        // Each vertex at a key of the world.
        let at_key = |key: usize| {
            let time = key as f64 / world_keys as f64;
            let (shape, part) = segment(time, mesh.later_shapes.len());
            let to_world = way.at(time);
            let vertices = shapes[shape].iter().zip(shapes[shape + 1]);
            let point = |(a, b): (&Vec3, &Vec3)| to_world.transform_point3(a.as_dvec3().lerp(b.as_dvec3(), part));
            vertices.map(point).collect::<Vec<DVec3>>()
        };
        // In a frame that stands still they go straight, too.
        let steps = if frame.parts > 0 { frame.parts.max(world_keys) / world_keys * STEPS } else { 1 };
        let mut start = at_key(0);
        for key in 0..world_keys {
            let end = at_key(key + 1);
            for step in 0..=steps {
                let part = step as f64 / steps as f64;
                let to_frame = frame.at((key as f64 + part) / world_keys as f64).inverse();
                start.iter().zip(&end).for_each(|(a, b)| self.add(to_frame.transform_point3(a.lerp(*b, part))));
            }
            start = end;
        }
    }
}
