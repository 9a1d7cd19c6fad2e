//! Geometry of a scene, `[scene]`: reading it and laying the tables of a capture file over it.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::super::tables::geometry_kind::upright;
use super::super::tables::spectra::Finder;
use super::super::tables::{CaptureFile, MaterialTable};
use super::super::tree::source::CaptureSource;
use super::default_light;
use super::environment::describe_environment;
use super::lights::describe_lights;
use super::materials::override_materials;
use super::models::{KnownModels, Model, ModelFile};
use super::moments::Moments;
use super::targets::scene_of;
use super::warnings;
use photosite_calibration::targets::PlacedTarget;
use photosite_core::Sandbox;
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Result};
use photosite_scene_io::MeshChange;
use photosite_transport::scene::description::{
    Colour, Diffuse, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription, SceneDescription,
    TexturedColour,
};

/// Geometry as read, before the tables of a capture file change it.
#[derive(Debug, Default)]
pub(crate) struct ReadScene {
    pub(crate) scene: SceneDescription,
    /// Materials of OBJ files that nothing has described yet.
    undescribed_materials: Vec<String>,
    models: KnownModels,
    /// Whether textures that are missing or broken get a stand-in.
    pub(crate) is_lenient: bool,
}

impl ReadScene {
    /// Reads all geometry of a capture file.
    pub(crate) fn of_capture(
        source: &CaptureSource,
        CaptureFile { scene: table, materials, .. }: &CaptureFile,
        moments: &Moments,
        folder: &Path,
        models: &KnownModels,
    ) -> Result<Self> {
        let mut read = Self { models: models.clone(), is_lenient: table.lenient, ..Self::default() };
        let scale = unit_length(table.meters_per_unit).map_err(|e| source.error(e.within("scene")))?;
        let (mut variants, mut animations) = (Vec::new(), Vec::new());
        for (i, file) in table.geometry.iter().enumerate() {
            let file = ModelFile {
                path: folder.join(file),
                variant: table.variant.clone(),
                moment: moments.of_scene.clone(),
                missing_normals: table.generate_normals.unwrap_or_default(),
                is_lenient: table.lenient,
            };
            let mut model = read.read(source, &format!("scene.geometry[{i}]"), &file)?;
            variants.append(&mut model.variants);
            animations.append(&mut model.animations);
            let scale = if model.is_metric { 1.0 } else { scale };
            let turn = upright(&file.path, table.up, "scene.up", &mut read.scene.warnings);
            let placed = read.merge(model);
            let stand = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, DVec3::ZERO);
            let SceneDescription { instances, lights, cameras, .. } = &mut read.scene;
            let instances = instances[placed.instances].iter_mut().map(|i| (&mut i.to_world, &mut i.later));
            let lights = lights[placed.lights].iter_mut().map(|light| (&mut light.to_world, &mut light.later));
            let cameras = cameras[placed.cameras].iter_mut().map(|camera| (&mut camera.to_world, &mut camera.later));
            for (to_world, later) in instances.chain(lights).chain(cameras) {
                std::iter::once(to_world).chain(later).for_each(|place| *place = stand * *place);
            }
            read.check_reach(&file.path)?;
        }
        let check = || {
            check_name("scene.variant", "material variant", table.variant.as_deref(), &variants)?;
            check_name("scene.animation", "animation", table.animation.as_deref(), &animations)
        };
        check().map_err(|invalid| source.error(invalid))?;
        read.add_objects(source, &table.objects, moments, folder, materials)?;
        Ok(read)
    }

    /// Geometry that comes from no file.
    pub(crate) fn of_description(scene: SceneDescription) -> Self {
        Self { scene, ..Self::default() }
    }

    /// Gives a scene that stands for a capture its light, unless its files have lights of their own.
    pub(crate) fn surround(&self, source: &mut CaptureSource) -> Result<()> {
        if self.scene.meshes.is_empty() {
            let help = "give a scene with geometry, or a capture file";
            return Err(Invalid::new("", "has no triangles").help(help).in_file(source.path()));
        }
        if self.scene.lights.is_empty() {
            default_light::set(source, &self.scene);
        }
        Ok(())
    }

    /// Reads a file of geometry, which `key` of the capture names.
    pub(crate) fn read(&self, source: &CaptureSource, key: &str, file: &ModelFile) -> Result<Model> {
        let path = &file.path;
        // What the user gave himself in the place of a capture may lie anywhere.
        if path != source.path() {
            source.sandbox().check(path).map_err(|invalid| source.error(invalid.within(key)))?;
        }
        // Found to be something else when it is read
        if !path.exists() || path.is_dir() {
            let (message, help) = if path.is_dir() {
                (format!("{} is a folder", path.display()), "name the .gltf, .glb, .obj, .ply or .stl file in it")
            } else {
                (format!("there is no file {}", path.display()), "paths are relative to the capture file")
            };
            return Err(source.error(Invalid::new(key, message).help(help)));
        }
        self.models.read(file, key, source)
    }

    /// Refuses what lies too far out, after the instances of a file were placed.
    fn check_reach(&self, path: &Path) -> Result<()> {
        if within_reach(&self.scene) {
            return Ok(());
        }
        let invalid = Invalid::new("", format!("reaches farther than {FARTHEST_M:e} m, too far to compute with"));
        let help = "export it in metres, or correct the scale of its nodes or meters_per_unit";
        Err(invalid.help(help).in_file(path))
    }

    /// Adds calibration targets.
    pub(crate) fn add_targets(&mut self, targets: &[PlacedTarget]) -> Result<(), Invalid> {
        for (i, target) in targets.iter().enumerate() {
            let scene = scene_of(target);
            if !within_reach(&scene) {
                let message = format!("lies farther out than {FARTHEST_M:e} m, too far to compute with");
                return Err(Invalid::new(format!("targets[{i}].position_m"), message));
            }
            self.merge(Model { scene, ..Model::default() });
        }
        Ok(())
    }

    /// Index of a material by name; one that the geometry lacks is added if the capture describes it.
    pub(crate) fn material_of(
        &mut self,
        name: &str,
        described: &BTreeMap<String, MaterialTable>,
        invalid: &impl Fn(&str, String) -> Invalid,
    ) -> Result<usize, Invalid> {
        let materials = &mut self.scene.materials;
        let of_geometry = materials.iter().position(|material| material.name == name);
        match (of_geometry, described.get(name)) {
            (Some(material), _) => Ok(material),
            (None, Some(MaterialTable::Kept(_))) => {
                let invalid = Invalid::new(format!("materials.{name}"), "the key `type` is missing");
                Err(invalid.help("no file of the geometry says what the material is"))
            }
            (None, Some(MaterialTable::Typed(_))) => {
                let reflectance = TexturedColour::plain(Colour::Rgb([0.5; 3]));
                materials.push(MaterialDescription::new(name, MaterialModel::Diffuse(Diffuse { reflectance })));
                Ok(materials.len() - 1)
            }
            (None, None) => {
                let of_files = materials.iter().map(|material| &material.name);
                let known: Vec<&str> = of_files.chain(described.keys()).map(String::as_str).collect();
                let hint = did_you_mean(name, known.iter().copied());
                let help = match known[..] {
                    [] => format!("describe it in a table [materials.{name}]"),
                    _ => format!("describe it in a table [materials.{name}]; there are {}", list(name, known)),
                };
                Err(invalid("material", format!("there is no material {name:?}{hint}")).help(help))
            }
        }
    }

    /// Appends a mesh that is there already, with another material if one is given.
    pub(crate) fn add_mesh_again(&mut self, mesh: usize, material: Option<usize>) {
        let mut mesh = Arc::clone(&self.scene.meshes[mesh]);
        if let Some(material) = material {
            let change = MeshChange::Material(material);
            self.models.change_meshes(|known| known.change(&mut mesh, change, |mesh| mesh.material = material));
        }
        self.scene.meshes.push(mesh);
    }

    /// Appends the contents of a file, whose indices move behind those that are there.
    pub(crate) fn merge(&mut self, model: Model) -> Merged {
        let Model { scene: other, mut undescribed_materials, .. } = model;
        self.undescribed_materials.append(&mut undescribed_materials);
        let scene = &mut self.scene;
        let (images, materials, meshes) = (scene.images.len(), scene.materials.len(), scene.meshes.len());
        let (instances, lights, cameras) = (scene.instances.len(), scene.lights.len(), scene.cameras.len());
        scene.images.extend(other.images);
        scene.materials.extend(other.materials.into_iter().map(|mut material| {
            material.change_textures(&mut |texture| texture.image += images);
            material
        }));
        self.models.change_meshes(|known| {
            scene.meshes.extend(other.meshes.into_iter().map(|mut mesh| {
                let material = mesh.material + materials;
                if materials > 0 {
                    known.change(&mut mesh, MeshChange::Material(material), |mesh| mesh.material = material);
                }
                mesh
            }));
        });
        scene.instances.extend(other.instances.into_iter().map(|mut instance| {
            instance.meshes = instance.meshes.start + meshes..instance.meshes.end + meshes;
            instance
        }));
        scene.lights.extend(other.lights);
        scene.cameras.extend(other.cameras);
        scene.files.extend(other.files);
        scene.warnings.extend(other.warnings);
        Merged {
            instances: instances..scene.instances.len(),
            lights: lights..scene.lights.len(),
            cameras: cameras..scene.cameras.len(),
        }
    }

    /// Lays materials, lights and environment of the capture file over the geometry.
    pub(crate) fn with_tables(
        mut self,
        file: &CaptureFile,
        folder: &Path,
        sandbox: &Sandbox,
    ) -> Result<SceneDescription, Invalid> {
        let mut finder = Finder::new(folder, sandbox, std::mem::take(&mut self.scene.images));
        let mut warnings = Warnings::default();
        let is_palette = !file.scene.objects.is_empty();
        override_materials(&file.materials, is_palette, &mut finder, &mut self.scene.materials, &mut warnings)?;
        describe_lights(&file.lights, &finder, &mut self.scene)?;
        // An object may have got another material for all of its file's.
        let seen = self.scene.instances.iter().flat_map(|instance| &self.scene.meshes[instance.meshes.clone()]);
        let used: BTreeSet<&str> = seen.map(|mesh| &*self.scene.materials[mesh.material].name).collect();
        let is_seen = |name: &&String| used.contains(name.as_str()) && !file.materials.contains_key(*name);
        for name in self.undescribed_materials.iter().filter(is_seen) {
            warnings.once(format!("nothing describes the material {name:?}; it is diffuse grey"));
        }
        if let Some(environment) = &file.scene.environment {
            let described = describe_environment(&finder, environment, &mut warnings);
            self.scene.environment = described.map_err(|e| e.within("environment").within("scene"))?;
        }
        self.scene.images = finder.into_images();
        self.scene.warnings.extend(warnings.into_messages());
        self.models.change_meshes(|known| photosite_scene_io::complete(&mut self.scene, known));
        let doubts = warnings::of(&self.scene);
        self.scene.warnings.extend(doubts);
        // Warnings stand in reports, which do not depend on how the path to the capture was typed.
        self.scene.warnings.iter_mut().for_each(|warning| *warning = seen_from(folder, warning));
        Ok(self.scene)
    }
}

/// Refuses a name that is not among those of its kind in the files.
pub(crate) fn check_name(key: &str, kind: &str, name: Option<&str>, known: &[String]) -> Result<(), Invalid> {
    let Some(name) = name.filter(|name| !known.iter().any(|known| known == name)) else { return Ok(()) };
    let names = || known.iter().map(String::as_str);
    let message = format!("the geometry has no {kind} {name:?}{}", did_you_mean(name, names()));
    let help = match known {
        [] => "its files have none; remove the key".to_owned(),
        _ => format!("its {kind}s are {}", list(name, names())),
    };
    Err(Invalid::new(key, message).help(help))
}

/// Coordinates beyond this have squares, such as areas, that come close to the largest number of single precision.
pub(crate) const FARTHEST_M: f64 = 1e18;

/// The largest coordinates of the meshes of each instance, in their own space.
pub(crate) fn extents(scene: &SceneDescription, instances: &[InstanceDescription]) -> Vec<DVec3> {
    let of_mesh = |mesh: &Arc<MeshDescription>| mesh.positions.iter().fold(Vec3::ZERO, |max, p| max.max(p.abs()));
    let of_meshes: Vec<DVec3> = scene.meshes.iter().map(|mesh| of_mesh(mesh).as_dvec3()).collect();
    let of_instance = |i: &InstanceDescription| of_meshes[i.meshes.clone()].iter().fold(DVec3::ZERO, |a, b| a.max(*b));
    instances.iter().map(of_instance).collect()
}

/// Whether geometry of this extent in its own space lies within [`FARTHEST_M`] of the origin along each axis.
pub(crate) fn is_within_reach(to_world: &DAffine3, extent: DVec3) -> bool {
    let DAffine3 { matrix3: m, translation } = to_world;
    let turned = DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs()) * extent;
    (turned + translation.abs()).max_element() <= FARTHEST_M
}

/// Whether all geometry lies within [`FARTHEST_M`] of the origin along each axis.
fn within_reach(scene: &SceneDescription) -> bool {
    let extents = extents(scene, &scene.instances);
    scene.instances.iter().zip(extents).all(|(instance, extent)| is_within_reach(&instance.to_world, extent))
}

/// Length of the unit of a file, m.
pub(crate) fn unit_length(meters_per_unit: Option<f64>) -> Result<f64, Invalid> {
    let scale = meters_per_unit.unwrap_or(1.0);
    if scale.is_finite() && scale > 0.0 {
        return Ok(scale);
    }
    let message = format!("must be above 0, got {scale}");
    Err(Invalid::new("meters_per_unit", message).help("for example meters_per_unit = 0.001 for millimetres"))
}

/// A text with paths into a folder as they read from there.
fn seen_from(folder: &Path, text: &str) -> String {
    // With a separator at its end.
    let typed = folder.join("").display().to_string();
    let (mut seen, mut from) = (String::new(), 0);
    for (i, _) in text.match_indices(&typed).filter(|_| !typed.is_empty()) {
        if i == 0 || text[..i].ends_with(' ') {
            seen.push_str(&text[from..i]);
            from = i + typed.len();
        }
    }
    seen + &text[from..]
}

/// Ranges of the scene that the contents of a file have become.
pub(crate) struct Merged {
    pub(crate) instances: Range<usize>,
    pub(crate) lights: Range<usize>,
    pub(crate) cameras: Range<usize>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_in_warnings_read_from_the_folder_of_the_capture() {
        let warning = "in/room.obj: line 1: the library in/my parts/a.mtl is missing; begin/end, /in/x";
        let seen = "room.obj: line 1: the library my parts/a.mtl is missing; begin/end, /in/x";
        assert_eq!(seen_from(Path::new("in"), warning), seen);
        assert_eq!(seen_from(Path::new(""), warning), warning);
        assert_eq!(seen_from(Path::new("/a b/c"), "/a b/c/d.hdr: 3 values"), "d.hdr: 3 values");
    }
}
