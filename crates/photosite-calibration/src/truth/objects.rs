//! Objects as ground truth knows them: their frames and their boxes.

use glam::{DAffine3, DVec3};

use photosite_transport::geometry::Motion;
use photosite_transport::scene::description::{ObjectDescription, SceneDescription, rigid};

/// An object. Its frame is turned and moved against the world, and not scaled.
#[derive(Clone, Debug)]
pub struct TruthObject {
    /// Its name.
    pub name: String,
    /// What kind of object it is, if that is known.
    pub category: Option<String>,
    /// What it is larger by than its file has it, along its axes.
    pub scale: DVec3,
    /// Frame → world; several at evenly spaced times where it moves.
    poses: Vec<DAffine3>,
    /// The least box in its frame that holds it, in all shapes and places that its parts go through, m.
    pub low: DVec3,
    /// Its other corner.
    pub high: DVec3,
    /// Points of it in its frame, m, by name.
    pub keypoints: Vec<(String, DVec3)>,
}

impl TruthObject {
    /// Those of a scene, in the order of their numbers.
    pub fn of_scene(scene: &SceneDescription) -> Vec<Self> {
        scene.all_objects().iter().map(|object| Self::new(object, scene)).collect()
    }

    fn new(object: &ObjectDescription, scene: &SceneDescription) -> Self {
        let frame = rigid(&object.to_world);
        let scaled = frame.inverse() * object.to_world;
        let scale = [scaled.matrix3.x_axis, scaled.matrix3.y_axis, scaled.matrix3.z_axis].map(DVec3::length);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for instance in &scene.instances[object.instances.clone()] {
            // Parts that an animation moves go through the object; where the object moves as a whole, its frame does.
            let later = if object.later.is_empty() { &instance.later[..] } else { &[] };
            for to_world in [&instance.to_world].into_iter().chain(later) {
                let to_frame = frame.inverse() * *to_world;
                for mesh in &scene.meshes[instance.meshes.clone()] {
                    let later = mesh.later_shapes.iter().map(|shape| &shape.positions);
                    for position in [&mesh.positions].into_iter().chain(later).flatten() {
                        let point = to_frame.transform_point3(position.as_dvec3());
                        (low, high) = (low.min(point), high.max(point));
                    }
                }
            }
        }
        let poses = [&object.to_world].into_iter().chain(&object.later).map(rigid);
        let keypoint = |(name, point): &(String, DVec3)| (name.clone(), scaled.transform_point3(*point));
        Self {
            name: object.name.clone(),
            category: object.category.clone(),
            scale: DVec3::from_array(scale),
            poses: poses.collect(),
            low,
            high,
            keypoints: object.keypoints.iter().map(keypoint).collect(),
        }
    }

    /// Frame → world when this part of the picture's time, 0 to 1, has gone by.
    pub fn to_world(&self, time: f32) -> DAffine3 {
        match self.poses[..] {
            [still] => still,
            _ => Motion::new(&self.poses).to_world(time),
        }
    }

    /// Whether it is somewhere else later in the time of the picture.
    pub fn moves(&self) -> bool {
        self.poses.len() > 1
    }

    /// The corners of its box in its frame, m: bit 0 of their number says whether x is the larger one, bit 1 y, bit 2 z.
    pub fn corners(&self) -> [DVec3; 8] {
        let pick = |i: usize, axis: usize| if i >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
        std::array::from_fn(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2)))
    }

    /// Where a point of its frame is in its box, as [`TruthLayer::Nocs`](super::TruthLayer::Nocs) has it.
    pub fn nocs(&self, point: DVec3) -> DVec3 {
        let (middle, diagonal) = ((self.low + self.high) / 2.0, (self.high - self.low).length());
        // An object without extent is in the middle.
        let part = if diagonal > 0.0 { (point - middle) / diagonal } else { DVec3::ZERO };
        part + 0.5
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use photosite_transport::scene::description::{InstanceDescription, MeshDescription};

    #[test]
    fn a_box_holds_parts_wherever_an_animation_moves_them() {
        let at = |x: f64| DAffine3::from_translation(DVec3::X * x);
        let mesh = MeshDescription { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], ..MeshDescription::default() };
        let part = InstanceDescription { later: vec![at(7.0)], ..InstanceDescription::of_mesh("part", 0, at(5.0)) };
        let object = ObjectDescription {
            name: "object".to_owned(),
            category: None,
            to_world: at(4.0),
            later: Vec::new(),
            keypoints: Vec::new(),
            instances: 0..1,
        };
        let of = |objects: Vec<ObjectDescription>| {
            let (meshes, instances) = (vec![mesh.clone().into()], vec![part.clone()]);
            TruthObject::of_scene(&SceneDescription { meshes, instances, objects, ..SceneDescription::default() })
        };
        let [placed] = &of(vec![object])[..] else { panic!("one object") };
        assert_eq!([placed.low, placed.high], [DVec3::X, DVec3::new(4.0, 1.0, 0.0)]);
        // By itself, the part is the object, whose frame goes along.
        let [alone] = &of(Vec::new())[..] else { panic!("one object") };
        assert_eq!([alone.low, alone.high], [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)]);
    }
}
