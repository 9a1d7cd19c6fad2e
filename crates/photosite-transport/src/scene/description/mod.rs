//! Description of a scene as files state it, before anything is prepared for rendering: meshes, instances, materials,
//! textures, lights and cameras in SI units and world axes (metres, right-handed, +Y up).
//!
//! The readers in `photosite-scene-io` fill these structures; [`scene::build`](crate::scene) turns them into tables.
//! Indices refer to the `Vec`s of the same [`SceneDescription`] and are checked by the readers.

mod camera;
mod layered;
mod lights;
mod material;
mod mesh;
mod model;
mod object;
mod texture;

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

use crate::geometry::QuadricKind;
use crate::texture::Bitmap;
use photosite_core::math::hash::hash64;

pub use crate::bsdf::models::*;
pub use crate::bsdf::{Mix, Model};
pub use crate::light::LightKind;
pub use camera::{CameraDescription, look_at, looking, vector};
pub use layered::{AnisotropyDescription, CoatDescription, FilmDescription, LayeredDescription};
pub use lights::{EmissionDescription, EnvironmentDescription, ImageLevel, LightDescription};
pub use material::{AlphaMode, MaterialDescription};
pub use mesh::{InstanceDescription, MeshDescription, ShapeDescription, pose_at};
pub use model::{Described, MaterialModel, Roughness, Visit};
pub use object::{ObjectDescription, rigid};
pub use texture::{Channel, Colour, TextureDescription, TexturedColour, TexturedFactor};

/// A whole scene as read from files.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Images that textures refer to.
    pub images: Vec<Arc<Bitmap>>,
    /// Materials that meshes refer to.
    pub materials: Vec<MaterialDescription>,
    /// Triangle meshes, each with one material. Scenes may share them.
    pub meshes: Vec<Arc<MeshDescription>>,
    /// Instances of meshes.
    pub instances: Vec<InstanceDescription>,
    /// Objects that were placed as such, in the order of their instances.
    pub objects: Vec<ObjectDescription>,
    /// Indices of the instances that surround the subject, as ground and backdrop do: they are no part of the size of
    /// the scene.
    pub surroundings: Vec<usize>,
    /// Lights without a surface.
    pub lights: Vec<LightDescription>,
    /// Light from infinitely far that surrounds the scene, if there is any.
    pub environment: Option<EnvironmentDescription>,
    /// Cameras of the files, in order.
    pub cameras: Vec<CameraDescription>,
    /// Files that the scene files refer to: buffers, images, material libraries, each once.
    pub files: Vec<PathBuf>,
    /// Warnings for the user, each once.
    pub warnings: Vec<String>,
}

impl SceneDescription {
    /// Corners of the subject, m: of all geometry but the surroundings.
    pub fn subject_points(&self) -> impl Iterator<Item = DVec3> + '_ {
        let subject = self.instances.iter().enumerate().filter(|(index, _)| !self.surroundings.contains(index));
        subject.flat_map(|(_, instance)| {
            let positions = self.meshes[instance.meshes.clone()].iter().flat_map(|mesh| &mesh.positions);
            positions.map(|p| instance.to_world.transform_point3(p.as_dvec3()))
        })
    }

    /// Lower and upper corner of the box around the subject, m; `None` where there is none.
    pub fn subject_bounds(&self) -> Option<(DVec3, DVec3)> {
        let all = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = self.subject_points().fold(all, |(low, high), p| (low.min(p), high.max(p)));
        (low.x <= high.x).then_some((low, high))
    }

    /// Objects in the order of their instances: those of [`objects`](Self::objects), and of the other instances each by
    /// itself. Ground truth numbers them from 1 on.
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
                    keypoints: Vec::new(),
                    instances: next..next + 1,
                });
            next = object.instances.end;
            all.push(object);
        }
        all
    }

    /// Whether the description shares all meshes with another, in memory.
    pub fn has_meshes_of(&self, other: &Self) -> bool {
        let pairs = || self.meshes.iter().zip(&other.meshes);
        self.meshes.len() == other.meshes.len() && pairs().all(|(own, other)| Arc::ptr_eq(own, other))
    }

    /// Hash of the surfaces: names, instances of meshes and their triangles, whatever their place and shape. Scenes
    /// with the same hash show the same surfaces, which may have moved.
    pub fn surfaces(&self) -> u64 {
        let text =
            |hash: u64, text: &str| text.bytes().fold(hash64(hash, text.len() as u64), |h, b| hash64(h, b.into()));
        let corners =
            |hash: u64, [a, b, c]: &[u32; 3]| hash64(hash, u64::from(*a) << 42 ^ u64::from(*b) << 21 ^ u64::from(*c));
        let of_meshes = self.meshes.iter().fold(self.meshes.len() as u64, |hash, mesh| {
            let kind = match mesh.quadric {
                None => 0,
                Some(QuadricKind::Sphere) => 1,
                Some(QuadricKind::Disk) => 2,
                Some(QuadricKind::Cylinder) => 3,
            };
            let named = hash64(text(hash, &mesh.name), kind);
            mesh.triangles.iter().fold(hash64(named, mesh.triangles.len() as u64), corners)
        });
        let of_instances = self.instances.iter().fold(of_meshes, |hash, instance| {
            let InstanceDescription { name, meshes, .. } = instance;
            meshes.clone().fold(text(hash, name), |hash, mesh| hash64(hash, mesh as u64))
        });
        self.objects.iter().fold(of_instances, |hash, object| {
            hash64(text(hash, &object.name), (object.instances.start as u64) << 32 ^ object.instances.end as u64)
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use glam::DAffine3;

    use super::*;

    #[test]
    fn every_instance_belongs_to_one_object() {
        let instances = (0..6).map(|i| InstanceDescription::of_mesh(format!("i{i}"), 0, DAffine3::IDENTITY)).collect();
        let object = |name: &str, instances: Range<usize>| ObjectDescription {
            name: name.to_owned(),
            category: None,
            to_world: DAffine3::IDENTITY,
            later: Vec::new(),
            keypoints: Vec::new(),
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
