//! Objects as ground truth knows them: their frames and their boxes.

use glam::{DAffine3, DVec3};

use super::extent::Extent;
use super::pose_path::PosePath;
use photosite_transport::scene::description::{ObjectDescription, SceneDescription, rigid};

/// Object of ground truth. Its frame is turned and moved against the world, and not scaled.
#[derive(Clone, Debug)]
pub struct TruthObject {
    /// Name of the object.
    pub name: String,
    /// Category of the object, if it is known.
    pub category: Option<String>,
    /// Scale of the object over that in its file, along its axes.
    pub scale: DVec3,
    /// Frame → world.
    frame: PosePath,
    /// Lowest corner of the least box in its frame that holds the object, in all shapes and places that its parts go
    /// through, m.
    pub low: DVec3,
    /// Corner of the box opposite to `low`, m.
    pub high: DVec3,
    /// Keypoints in the object's frame, m, by name.
    pub keypoints: Vec<(String, DVec3)>,
}

impl TruthObject {
    /// Objects of a scene, in the order of their numbers.
    pub fn of_scene(scene: &SceneDescription) -> Vec<Self> {
        scene.all_objects().iter().map(|object| Self::new(object, scene)).collect()
    }

    fn new(object: &ObjectDescription, scene: &SceneDescription) -> Self {
        let frame = rigid(&object.to_world);
        let scaled = frame.inverse() * object.to_world;
        let scale = [scaled.matrix3.x_axis, scaled.matrix3.y_axis, scaled.matrix3.z_axis].map(DVec3::length);
        let frame = PosePath::new(frame, object.later.iter().map(rigid));
        let Extent { low, high } = Extent::of_object(&frame, &scene.instances[object.instances.clone()], scene);
        let keypoint = |(name, point): &(String, DVec3)| (name.clone(), scaled.transform_point3(*point));
        Self {
            name: object.name.clone(),
            category: object.category.clone(),
            scale: DVec3::from_array(scale),
            frame,
            low,
            high,
            keypoints: object.keypoints.iter().map(keypoint).collect(),
        }
    }

    /// Frame → world when this part of the image's time, 0 to 1, has gone by.
    pub fn to_world(&self, time: f64) -> DAffine3 {
        self.frame.at(time)
    }

    /// Whether the object is somewhere else later in the time of the image.
    pub fn moves(&self) -> bool {
        self.frame.parts > 0
    }

    /// The corners of its box in its frame, m: bit 0 of their number says whether x is the larger one, bit 1 y, bit 2
    /// z.
    pub fn corners(&self) -> [DVec3; 8] {
        let pick = |i: usize, axis: usize| if i >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
        std::array::from_fn(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2)))
    }

    /// Normalised coordinates of a point of the frame in the object's box, as
    /// [`TruthLayer::Nocs`](super::TruthLayer::Nocs) has them.
    pub fn nocs(&self, point: DVec3) -> DVec3 {
        let (middle, diagonal) = ((self.low + self.high) / 2.0, (self.high - self.low).length());
        // An object without extent is in the middle.
        let part = if diagonal > 0.0 { (point - middle) / diagonal } else { DVec3::ZERO };
        // The rounding of a hit may lie beyond the box.
        (part + 0.5).clamp(DVec3::ZERO, DVec3::ONE)
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

    /// A part that slides through an object which moves, and an object that grows: points of either, where they are at
    /// a time, lie in the box at all times.
    #[test]
    fn a_box_holds_what_animates_in_an_object_that_moves() {
        let at = |x: f64, scale: f64| {
            let turn = glam::DQuat::from_rotation_y(0.7 * x);
            DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, DVec3::new(x, 0.0, -x))
        };
        let mesh = MeshDescription { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], ..MeshDescription::default() };
        let frames: Vec<DAffine3> = (0..=4).map(|i| at(0.1 * f64::from(i), 1.0)).collect();
        let part = |i: usize| {
            frames[i]
                * DAffine3::from_translation(DVec3::X * i as f64)
                * DAffine3::from_scale(DVec3::splat(1.0 + i as f64))
        };
        let instance = InstanceDescription {
            later: (1..=4).map(part).collect(),
            ..InstanceDescription::of_mesh("part", 0, part(0))
        };
        let object = ObjectDescription {
            name: "object".to_owned(),
            category: None,
            to_world: frames[0],
            later: frames[1..].to_vec(),
            keypoints: Vec::new(),
            instances: 0..1,
        };
        let scene = SceneDescription {
            meshes: vec![mesh.clone().into()],
            instances: vec![instance.clone()],
            objects: vec![object],
            ..SceneDescription::default()
        };
        let [placed] = &TruthObject::of_scene(&scene)[..] else { panic!("one object") };
        // From x = 0 to 4 + 5 along x, up to 5 along y.
        assert!((placed.high - DVec3::new(9.0, 5.0, placed.high.z)).length() < 1e-3, "{}", placed.high);
        let room = 1e-5;
        for step in 0..=100 {
            let time = f64::from(step) / 100.0;
            for corner in &mesh.positions {
                let point = instance.at(time).transform_point3(corner.as_dvec3());
                let own = placed.to_world(time).inverse().transform_point3(point);
                assert!(own.cmpge(placed.low - room).all() && own.cmple(placed.high + room).all(), "{time}: {own}");
            }
        }
    }
}
