//! Objects behind the instance numbers of ground truth, each with one number or several.

use glam::DAffine3;

use photosite_core::image::Planes;
use photosite_transport::scene::description::{InstanceDescription, SceneDescription};

/// Object: everything that bears the same name in the same place. A target of two inks has two numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// Name of the object.
    pub name: String,
    /// Category of the object, if known.
    pub category: Option<String>,
    /// Pose: the object's own frame → world, as in the scene, m.
    pub to_world: DAffine3,
    /// Instance numbers of the object in ground truth, which count from 1.
    pub numbers: Vec<u32>,
}

impl SceneObject {
    /// Objects of a scene.
    pub fn of_scene(scene: &SceneDescription) -> Vec<Self> {
        Self::of_numbers(scene.all_objects().into_iter().map(|object| (object.name, object.category, object.to_world)))
    }

    /// Objects from names and places in the order of their instance numbers. The parts of an object follow one another.
    pub fn of_numbers(numbered: impl IntoIterator<Item = (String, Option<String>, DAffine3)>) -> Vec<Self> {
        let mut objects: Vec<Self> = Vec::new();
        for (number, (name, category, to_world)) in (1..).zip(numbered) {
            match objects.last_mut() {
                Some(object) if object.name == name && object.to_world == to_world => object.numbers.push(number),
                Some(_) | None => objects.push(Self { name, category, to_world, numbers: vec![number] }),
            }
        }
        objects
    }
}

impl SceneObject {
    /// Instances of the object in its scene.
    pub(super) fn instances<'a>(&self, scene: &'a SceneDescription) -> Vec<&'a InstanceDescription> {
        let all = scene.all_objects();
        let objects = self.numbers.iter().filter_map(|&number| all.get(number as usize - 1));
        objects.flat_map(|object| &scene.instances[object.instances.clone()]).collect()
    }
}

/// Index of the object that each pixel sees.
pub(super) fn object_of_pixel(truth: &Planes, objects: &[SceneObject]) -> Vec<Option<usize>> {
    let count = objects.iter().flat_map(|object| &object.numbers).max().map_or(0, |&n| n as usize + 1);
    let mut of_number = vec![None; count];
    for (index, object) in objects.iter().enumerate() {
        object.numbers.iter().for_each(|&number| of_number[number as usize] = Some(index));
    }
    let plane = truth.plane("instance").unwrap_or_default();
    plane.iter().map(|&number| of_number.get(number as usize).copied().flatten()).collect()
}
