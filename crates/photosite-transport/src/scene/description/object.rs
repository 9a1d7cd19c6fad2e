//! Objects: what ground truth tells apart, and what stands in one pose.

use std::ops::Range;

use glam::DAffine3;

use super::SceneDescription;
use super::mesh::pose_at;

/// Instances that make one object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectDescription {
    /// Its name.
    pub name: String,
    /// What kind of object it is, if that is known.
    pub category: Option<String>,
    /// Object space → world.
    pub to_world: DAffine3,
    /// The same at the evenly spaced times that follow in the time of the picture, where it moves.
    pub later: Vec<DAffine3>,
    /// Indices of its instances; not empty.
    pub instances: Range<usize>,
}

impl ObjectDescription {
    /// Object space → world when this part of the picture's time, 0 to 1, has gone by.
    pub fn at(&self, time: f32) -> DAffine3 {
        pose_at(&self.to_world, &self.later, time)
    }
}

impl SceneDescription {
    /// All objects, in the order of their instances: those of [`objects`](Self::objects), and of the other instances
    /// each by itself. Ground truth numbers them from 1 on.
    pub fn all_objects(&self) -> Vec<ObjectDescription> {
        let mut all = Vec::with_capacity(self.instances.len());
        let mut placed = self.objects.iter().peekable();
        let mut next = 0;
        while let Some(instance) = self.instances.get(next) {
            let object =
                placed.next_if(|object| object.instances.start == next).cloned().unwrap_or_else(|| ObjectDescription {
                    name: instance.name.clone(),
                    category: None,
                    to_world: instance.to_world,
                    later: instance.later.clone(),
                    instances: next..next + 1,
                });
            next = object.instances.end;
            all.push(object);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::super::InstanceDescription;
    use super::*;

    #[test]
    fn every_instance_belongs_to_one_object() {
        let instances = (0..6).map(|i| InstanceDescription::of_mesh(format!("i{i}"), 0, DAffine3::IDENTITY)).collect();
        let object = |name: &str, instances: Range<usize>| ObjectDescription {
            name: name.to_owned(),
            category: None,
            to_world: DAffine3::IDENTITY,
            later: Vec::new(),
            instances,
        };
        let objects = vec![object("a", 1..3), object("b", 4..5)];
        let scene = SceneDescription { instances, objects, ..SceneDescription::default() };
        let found: Vec<(String, Range<usize>)> =
            scene.all_objects().into_iter().map(|object| (object.name, object.instances)).collect();
        let expected = [("i0", 0..1), ("a", 1..3), ("i3", 3..4), ("b", 4..5), ("i5", 5..6)];
        assert_eq!(found, expected.map(|(name, instances)| (name.to_owned(), instances)));
    }
}
