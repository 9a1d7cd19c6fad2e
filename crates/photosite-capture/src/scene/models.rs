//! Files of geometry, each of which is read once for all objects of a capture and for all captures of a data set.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

use super::super::tables::geometry_kind::GeometryKind;
use super::super::tree::source::CaptureSource;
use photosite_core::input;
use photosite_core::locked::locked;
use photosite_core::{Invalid, Result};
use photosite_scene_io::gltf::{self, Choice, Moment};
use photosite_scene_io::{ChangedMeshes, MissingNormals, obj, ply, stl};
use photosite_transport::scene::description::{MeshDescription, SceneDescription};
use photosite_transport::texture::Bitmap;

/// Contents of a file of geometry.
#[derive(Clone, Debug, Default)]
pub(crate) struct Model {
    pub(crate) scene: SceneDescription,
    /// Materials that nothing has described yet.
    pub(crate) undescribed_materials: Vec<String>,
    /// Names of material variants.
    pub(crate) variants: Vec<String>,
    /// Names of animations.
    pub(crate) animations: Vec<String>,
    /// Whether its lengths are metres whatever a capture says.
    pub(crate) is_metric: bool,
}

impl Model {
    /// Memory that the model takes, roughly, bytes.
    fn bytes(&self) -> usize {
        let of_mesh = |mesh: &Arc<MeshDescription>| {
            let shapes = 1 + mesh.later_shapes.len();
            mesh.positions.len() * (24 * shapes + 32 + 8 * mesh.uvs.len()) + mesh.triangles.len() * 12
        };
        let of_image = |image: &Arc<Bitmap>| image.width * image.height * 16;
        self.scene.meshes.iter().map(of_mesh).sum::<usize>() + self.scene.images.iter().map(of_image).sum::<usize>()
    }
}

/// A file, and how it is read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ModelFile {
    pub(crate) path: PathBuf,
    pub(crate) variant: Option<String>,
    pub(crate) moment: Option<Moment>,
    pub(crate) missing_normals: MissingNormals,
    /// Whether textures that are missing or broken get a stand-in.
    pub(crate) is_lenient: bool,
}

impl ModelFile {
    /// Reads the file. `key` names it in the capture.
    fn read(&self, key: &str, source: &CaptureSource) -> Result<Model> {
        let &Self { ref path, ref variant, ref moment, missing_normals, is_lenient } = self;
        match GeometryKind::of(path) {
            Some(GeometryKind::Gltf) => {
                let choice = Choice {
                    variant: variant.as_deref(),
                    moment: moment.as_ref(),
                    sandbox: Some(source.sandbox()),
                    is_lenient,
                };
                let gltf::GltfFile { scene, variants, animations } = gltf::read(path, choice)?;
                Ok(Model { scene, variants, animations, is_metric: true, ..Model::default() })
            }
            Some(GeometryKind::Obj) => {
                let choice = obj::Choice { missing_normals, sandbox: source.sandbox().clone(), is_lenient };
                let obj::ObjFile { scene, undescribed_materials } = obj::read(path, &choice)?;
                Ok(Model { scene, undescribed_materials, ..Model::default() })
            }
            Some(GeometryKind::Ply) => {
                let scene = ply::read(path, missing_normals, source.sandbox())?;
                Ok(Model { scene, ..Model::default() })
            }
            Some(GeometryKind::Stl) => {
                let scene = stl::read(path, missing_normals)?;
                Ok(Model { scene, ..Model::default() })
            }
            None => {
                let message = format!("{} is not a scene of a known kind", path.display());
                let help = "geometry is read from .gltf, .glb, .obj, .ply and .stl files";
                Err(source.error(Invalid::new(key, message).help(help)))
            }
        }
    }

    /// Time of the last change of the file, and its size in bytes.
    fn stamp(&self) -> Option<(SystemTime, u64)> {
        let facts = input::metadata(&self.path).ok()?;
        Some((facts.modified().ok()?, facts.len()))
    }
}

/// Models that were read, for the captures of a data set. A file that has changed since is read again.
#[derive(Clone, Debug, Default)]
pub(crate) struct KnownModels(Option<Arc<Mutex<Known>>>);

#[derive(Debug, Default)]
struct Known {
    /// Models in the order in which they were read, the last one last.
    models: Vec<KnownModel>,
    meshes: ChangedMeshes,
}

#[derive(Debug)]
struct KnownModel {
    file: ModelFile,
    stamp: Option<(SystemTime, u64)>,
    model: Arc<Model>,
}

/// Bytes that models are kept up to; beyond, those that were read first are forgotten.
const MOST_BYTES: usize = 2 << 30;

impl Known {
    fn find(&self, file: &ModelFile, stamp: Option<(SystemTime, u64)>) -> Option<Arc<Model>> {
        let known = self.models.iter().find(|known| known.file == *file && known.stamp == stamp)?;
        Some(Arc::clone(&known.model))
    }

    fn add(&mut self, known: KnownModel) {
        self.models.retain(|other| other.file != known.file);
        self.models.push(known);
        let mut bytes = 0;
        let kept = self.models.iter().rev().take_while(|known| {
            bytes += known.model.bytes();
            bytes <= MOST_BYTES
        });
        let forgotten = self.models.len() - kept.count().max(1);
        if forgotten > 0 {
            self.models.drain(..forgotten);
            self.meshes = ChangedMeshes::default();
        }
    }
}

impl KnownModels {
    /// Models that are kept. By default none are.
    pub(crate) fn kept() -> Self {
        Self(Some(Arc::default()))
    }

    /// Reads a file, or takes what was read of it before. `key` names it in the capture.
    pub(crate) fn read(&self, file: &ModelFile, key: &str, source: &CaptureSource) -> Result<Model> {
        let Some(known) = &self.0 else { return file.read(key, source) };
        let stamp = file.stamp();
        let lock = || locked(known);
        if let Some(model) = lock().find(file, stamp) {
            return Ok(Model::clone(&model));
        }
        let model = Arc::new(file.read(key, source)?);
        lock().add(KnownModel { file: file.clone(), stamp, model: Arc::clone(&model) });
        Ok(Model::clone(&model))
    }

    /// Changes meshes, of which those that others share stay as they are.
    pub(crate) fn change_meshes<T>(&self, change: impl FnOnce(&mut ChangedMeshes) -> T) -> T {
        match &self.0 {
            Some(known) => change(&mut locked(known).meshes),
            None => change(&mut ChangedMeshes::default()),
        }
    }
}
