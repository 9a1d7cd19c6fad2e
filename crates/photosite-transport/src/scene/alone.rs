//! Objects by themselves, as if the scene held nothing else.

use super::Scene;
use crate::geometry::{HitFilter, Primitive, Ray};

/// Object by itself, with the instances that hold its surfaces.
#[derive(Clone, Debug, Default)]
pub struct ObjectAlone {
    /// Index of the object.
    object: u32,
    /// Instances of the geometry that hold nothing else.
    own: Vec<u32>,
    /// Instances of the geometry that hold others as well.
    shared: Vec<u32>,
}

impl Scene {
    /// Objects by themselves, one each, in the order of [`object`](Self::object).
    pub fn objects_alone(&self) -> Vec<ObjectAlone> {
        let count = self.objects.iter().max().map_or(0, |last| last + 1);
        let mut all: Vec<ObjectAlone> = (0..count).map(|object| ObjectAlone { object, ..Default::default() }).collect();
        let object_of = |instance: u32| self.objects[instance as usize] as usize;
        for (placed, instance) in (0..).zip(&self.instances.of_placed) {
            if let Some(instance) = instance {
                all[object_of(*instance)].own.push(placed);
            }
        }
        let in_world = self.instances.of_placed.iter().take_while(|instance| instance.is_none()).count();
        for part in &self.instances.of_mesh {
            let object = &mut all[object_of(part.instance)];
            if object.shared.is_empty() {
                object.shared.extend(0..in_world as u32);
            }
        }
        all
    }

    /// Whether a ray meets an object, whatever is in front of it.
    pub fn meets(&self, alone: &ObjectAlone, ray: &Ray) -> bool {
        let filter = OfObject { scene: self, object: alone.object };
        let mut instances = alone.own.iter().chain(&alone.shared);
        instances.any(|&instance| self.accel.meets(instance, ray, &filter))
    }
}

/// Lets rays through whatever is not of one object, and through its holes.
struct OfObject<'a> {
    scene: &'a Scene,
    object: u32,
}

impl HitFilter for OfObject<'_> {
    fn accept(&self, primitive: Primitive, uv: [f32; 2], ray: &Ray) -> bool {
        let Scene { geometry, instances, objects, .. } = self.scene;
        // Meshes in spaces of their own are told apart by their instances.
        let part = instances.of_mesh.get(geometry.mesh_of(primitive) as usize);
        let is_own = part.is_none_or(|part| objects[part.instance as usize] == self.object);
        is_own && super::Holes(self.scene).accept(primitive, uv, ray)
    }
}
