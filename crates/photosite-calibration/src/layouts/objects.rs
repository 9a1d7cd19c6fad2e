//! What instance numbers of ground truth are numbers of: things that consist of one or several instances.

use glam::DAffine3;

use photosite_core::image::Planes;

/// A thing: all that bears the same name in the same place. An instance has one material only, so that a target of two
/// inks is two instances.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// Its name.
    pub name: String,
    /// Its own frame → world, as the scene has it, m.
    pub to_world: DAffine3,
    /// Its numbers in ground truth, which count from 1.
    pub numbers: Vec<u32>,
}

impl SceneObject {
    /// The objects that instances make, by their names and places in the order of their numbers. The parts of an object
    /// follow one another.
    pub fn of_instances(instances: impl IntoIterator<Item = (String, DAffine3)>) -> Vec<Self> {
        let mut objects: Vec<Self> = Vec::new();
        for (number, (name, to_world)) in (1..).zip(instances) {
            match objects.last_mut() {
                Some(object) if object.name == name && object.to_world == to_world => object.numbers.push(number),
                Some(_) | None => objects.push(Self { name, to_world, numbers: vec![number] }),
            }
        }
        objects
    }
}

/// For each pixel, the index of the object that it sees.
pub(super) fn object_of_pixel(truth: &Planes, objects: &[SceneObject]) -> Vec<Option<usize>> {
    let count = objects.iter().flat_map(|object| &object.numbers).max().map_or(0, |&n| n as usize + 1);
    let mut of_number = vec![None; count];
    for (index, object) in objects.iter().enumerate() {
        object.numbers.iter().for_each(|&number| of_number[number as usize] = Some(index));
    }
    let plane = truth.plane("instance").unwrap_or_default();
    plane.iter().map(|&number| of_number.get(number as usize).copied().flatten()).collect()
}
