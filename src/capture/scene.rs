//! `[scene]`: reading geometry and laying the tables of a capture file over it.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use serde_json::json;

use super::colour::Finder;
use super::environment::describe_environment;
use super::geometry_kind::GeometryKind;
use super::light::describe_lights;
use super::material::override_materials;
use super::source::CaptureSource;
use super::tables::{CaptureFile, MaterialTable, NormalsName, SceneTable};
use super::target::scene_of;
use crate::calibration::targets::PlacedTarget;
use crate::geometry::QuadricKind;
use crate::io::gltf::{self, Choice, Moment};
use crate::io::{MissingNormals, obj, ply, stl};
use crate::scene::description::{
    Colour, Diffuse, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription, SceneDescription,
    TexturedColour,
};
use crate::{Invalid, Result};
use photosite_core::Sandbox;
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::warnings::Warnings;

/// Illuminance of the surroundings of scenes that have no light, lux: a bright room.
const DEFAULT_ILLUMINANCE_LUX: f64 = 500.0;

/// Geometry as read, before the tables of a capture file change it.
#[derive(Debug, Default)]
pub(super) struct ReadScene {
    pub(super) scene: SceneDescription,
    /// Materials of OBJ files that nothing has described yet.
    undescribed_materials: Vec<String>,
    /// Material variants of glTF files.
    variants: Vec<String>,
    /// Animations of glTF files.
    animations: Vec<String>,
}

impl ReadScene {
    /// Reads all geometry of a capture file.
    pub(super) fn of_capture(
        source: &CaptureSource,
        table: &SceneTable,
        moment: Option<&Moment>,
        folder: &Path,
    ) -> Result<Self> {
        let mut read = Self::default();
        for (i, file) in table.geometry.iter().enumerate() {
            let path = folder.join(file);
            let key = format!("scene.geometry[{i}]");
            // What the user gave himself in the place of a capture may lie anywhere.
            if path != source.path() {
                source.sandbox().check(&path).map_err(|invalid| source.error(invalid.within(&key)))?;
            }
            // Found to be something else when it is read
            if !path.exists() || path.is_dir() {
                let message = format!("there is no file {}", path.display());
                let help = "paths are relative to the capture file";
                return Err(source.error(Invalid::new(key, message).help(help)));
            }
            read.add(source, table, moment, &path, i)?;
        }
        read.check_names(table).map_err(|invalid| source.error(invalid))?;
        Ok(read)
    }

    /// Geometry that comes from no file.
    pub(super) fn of_description(scene: SceneDescription) -> Self {
        Self { scene, ..Self::default() }
    }

    /// Gives a scene that stands for a capture its surroundings, unless its files have lights of their own.
    pub(super) fn surround(&self, source: &mut CaptureSource) -> Result<()> {
        if self.scene.meshes.is_empty() {
            let help = "give a scene with geometry, or a capture file";
            return Err(Invalid::new("", "has no triangles").help(help).in_file(source.path()));
        }
        if self.scene.lights.is_empty() {
            let daylight = json!({ "illuminant": "D65", "illuminance_lux": DEFAULT_ILLUMINANCE_LUX });
            source.set_default("scene", "environment", &daylight);
        }
        Ok(())
    }

    /// Reads a file of geometry and adds what it holds.
    fn add(
        &mut self,
        source: &CaptureSource,
        table: &SceneTable,
        moment: Option<&Moment>,
        path: &Path,
        index: usize,
    ) -> Result<()> {
        let missing = match table.generate_normals {
            None | Some(NormalsName::Flat) => MissingNormals::Flat,
            Some(NormalsName::Smooth) => MissingNormals::Smooth,
        };
        let kind = GeometryKind::of(path);
        let mut scene = match kind {
            Some(GeometryKind::Gltf) => {
                let mut file = gltf::read(
                    path,
                    Choice { variant: table.variant.as_deref(), moment, sandbox: Some(source.sandbox()) },
                )?;
                self.variants.append(&mut file.variants);
                self.animations.append(&mut file.animations);
                file.scene
            }
            Some(GeometryKind::Obj) => {
                let mut file = obj::read(path, missing, source.sandbox())?;
                self.undescribed_materials.append(&mut file.undescribed_materials);
                file.scene
            }
            Some(GeometryKind::Ply) => ply::read(path, missing, source.sandbox())?,
            Some(GeometryKind::Stl) => stl::read(path, missing)?,
            None => {
                let message = format!("{} is no scene of a known kind", path.display());
                let invalid = Invalid::new(format!("scene.geometry[{index}]"), message);
                return Err(source.error(invalid.help("geometry is read from .gltf, .glb, .obj, .ply and .stl files")));
            }
        };
        if kind.is_some_and(|kind| !kind.is_in_metres()) {
            let scale = unit_length(table).map_err(|invalid| source.error(invalid.within("scene")))?;
            for instance in &mut scene.instances {
                instance.to_world = DAffine3::from_scale(DVec3::splat(scale)) * instance.to_world;
            }
        }
        if !within_reach(&scene) {
            let invalid = Invalid::new("", format!("reaches farther than {FARTHEST_M:e} m, too far to compute with"));
            let help = "export it in metres, or correct the scale of its nodes or meters_per_unit";
            return Err(invalid.help(help).in_file(path));
        }
        self.merge(scene);
        Ok(())
    }

    /// Adds calibration targets.
    pub(super) fn add_targets(&mut self, targets: &[PlacedTarget]) -> Result<(), Invalid> {
        for (i, target) in targets.iter().enumerate() {
            let scene = scene_of(target);
            if !within_reach(&scene) {
                let message = format!("lies farther out than {FARTHEST_M:e} m, too far to compute with");
                return Err(Invalid::new(format!("targets[{i}].position_m"), message));
            }
            self.merge(scene);
        }
        Ok(())
    }

    /// Adds spheres, disks and cylinders. Materials that no file of the geometry has are those of `described` names.
    pub(super) fn add_quadrics(
        &mut self,
        table: &SceneTable,
        described: &BTreeMap<String, MaterialTable>,
    ) -> Result<(), Invalid> {
        for quadric in quadrics(table) {
            let Quadric { kind, index, position_m, axis, radius_m, length_m, .. } = quadric;
            let invalid = |key: &str, message: String| Invalid::new(format!("{}.{key}", place(kind, index)), message);
            let (centre, reach) = (DVec3::from_array(position_m), radius_m.abs() + length_m.map_or(0.0, f64::abs));
            if !(centre.is_finite() && (centre.abs() + reach).max_element() <= FARTHEST_M) {
                return Err(invalid(
                    "position_m",
                    format!("lies farther out than {FARTHEST_M:e} m, too far to compute with"),
                ));
            }
            // The square of a smaller one has no digits in single precision.
            for (key, size) in [("radius_m", Some(radius_m)), ("length_m", length_m)] {
                if size.is_some_and(|size| size.is_nan() || size < SMALLEST_SIZE_M) {
                    let size = size.unwrap_or_default();
                    return Err(invalid(key, format!("must be at least {SMALLEST_SIZE_M:e}, got {size}")));
                }
            }
            let turn = match axis {
                None => DQuat::IDENTITY,
                Some((key, axis)) => match DVec3::from_array(axis).try_normalize() {
                    Some(axis) => DQuat::from_rotation_arc(DVec3::Z, axis),
                    None => {
                        let message = format!("must be a direction, got {axis:?}");
                        return Err(invalid(key, message).help(format!("for example {key} = [0, 1, 0] for upwards")));
                    }
                },
            };
            let material = self.material_of(quadric.material, described, &invalid)?;
            let name = quadric.name.map_or_else(|| format!("{}-{index}", kind.name()), str::to_owned);
            // The unit cylinder begins at the origin, and this one at half of its length from its middle.
            let length = length_m.unwrap_or(radius_m);
            let origin = centre - turn * DVec3::Z * (length_m.unwrap_or(0.0) / 2.0);
            let scale = DVec3::new(radius_m, radius_m, length);
            let to_world = DAffine3::from_scale_rotation_translation(scale, turn, origin);
            let mesh = self.scene.meshes.len();
            self.scene.meshes.push(MeshDescription::of_quadric(kind, name.clone(), material));
            self.scene.instances.push(InstanceDescription { name, mesh, to_world, later: vec![] });
        }
        Ok(())
    }

    /// Index of a material that a quadric names; one that the geometry lacks is added if the capture describes it.
    fn material_of(
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

    /// Refuses names of variants and animations that no file has.
    fn check_names(&self, table: &SceneTable) -> Result<(), Invalid> {
        check_name("variant", "material variant", table.variant.as_deref(), &self.variants)?;
        check_name("animation", "animation", table.animation.as_deref(), &self.animations)
    }

    /// Appends another scene, whose indices move behind those that are there.
    fn merge(&mut self, other: SceneDescription) {
        let scene = &mut self.scene;
        let (images, materials, meshes) = (scene.images.len(), scene.materials.len(), scene.meshes.len());
        scene.images.extend(other.images);
        scene.materials.extend(other.materials.into_iter().map(|mut material| {
            material.change_textures(&mut |texture| texture.image += images);
            material
        }));
        scene.meshes.extend(other.meshes.into_iter().map(|mut mesh| {
            mesh.material += materials;
            mesh
        }));
        scene.instances.extend(other.instances.into_iter().map(|mut instance| {
            instance.mesh += meshes;
            instance
        }));
        scene.lights.extend(other.lights);
        scene.cameras.extend(other.cameras);
        scene.files.extend(other.files);
        scene.warnings.extend(other.warnings);
    }

    /// Lays materials, lights and environment of the capture file over the geometry.
    pub(super) fn with_tables(
        mut self,
        file: &CaptureFile,
        folder: &Path,
        sandbox: &Sandbox,
    ) -> Result<SceneDescription, Invalid> {
        let mut finder = Finder::new(folder, sandbox, std::mem::take(&mut self.scene.images));
        override_materials(&file.materials, &mut finder, &mut self.scene.materials)?;
        describe_lights(&file.lights, &finder, &mut self.scene)?;
        let mut warnings = Warnings::default();
        for name in self.undescribed_materials.iter().filter(|name| !file.materials.contains_key(*name)) {
            warnings.once(format!("nothing describes the material {name:?}; it is diffuse grey"));
        }
        let emits = |material: usize| self.scene.materials[material].emission.is_some();
        let named = |name: &str| self.scene.materials.iter().position(|material| material.name == name);
        if let Some(quadric) = quadrics(&file.scene).find(|quadric| named(quadric.material).is_some_and(emits)) {
            let Quadric { kind, index, material, .. } = quadric;
            let message = format!("{material:?} shines, but a {} cannot", kind.name());
            let help = "give the lamp as a mesh, or as a light of [[lights]]";
            return Err(Invalid::new(format!("{}.material", place(kind, index)), message).help(help));
        }
        if let Some(environment) = &file.scene.environment {
            let described = describe_environment(&finder, environment, &mut warnings);
            self.scene.environment = described.map_err(|e| e.within("environment").within("scene"))?;
        }
        self.scene.images = finder.into_images();
        self.scene.warnings.extend(warnings.into_messages());
        crate::io::complete(&mut self.scene);
        if !shines(&self.scene) {
            self.scene.warnings.push("nothing in the scene gives light, so the picture will be black".to_owned());
        }
        // Warnings stand in reports, which do not depend on how the path to the capture was typed.
        self.scene.warnings.iter_mut().for_each(|warning| *warning = seen_from(folder, warning));
        Ok(self.scene)
    }
}

/// A table of a quadric, of whatever kind.
struct Quadric<'a> {
    kind: QuadricKind,
    /// Number among those of its kind.
    index: usize,
    name: Option<&'a str>,
    material: &'a str,
    position_m: [f64; 3],
    /// The direction of what is +Z of the unit shape, with its key.
    axis: Option<(&'static str, [f64; 3])>,
    radius_m: f64,
    length_m: Option<f64>,
}

/// All of them: a row for each kind.
fn quadrics(table: &SceneTable) -> impl Iterator<Item = Quadric<'_>> {
    let spheres = table.spheres.iter().enumerate().map(|(index, sphere)| Quadric {
        kind: QuadricKind::Sphere,
        index,
        name: sphere.name.as_deref(),
        material: &sphere.material,
        position_m: sphere.position_m,
        axis: None,
        radius_m: sphere.radius_m,
        length_m: None,
    });
    let disks = table.disks.iter().enumerate().map(|(index, disk)| Quadric {
        kind: QuadricKind::Disk,
        index,
        name: disk.name.as_deref(),
        material: &disk.material,
        position_m: disk.position_m,
        axis: Some(("normal", disk.normal)),
        radius_m: disk.radius_m,
        length_m: None,
    });
    let cylinders = table.cylinders.iter().enumerate().map(|(index, cylinder)| Quadric {
        kind: QuadricKind::Cylinder,
        index,
        name: cylinder.name.as_deref(),
        material: &cylinder.material,
        position_m: cylinder.position_m,
        axis: Some(("axis", cylinder.axis)),
        radius_m: cylinder.radius_m,
        length_m: Some(cylinder.length_m),
    });
    spheres.chain(disks).chain(cylinders)
}

/// The path of a table in the capture file.
fn place(kind: QuadricKind, index: usize) -> String {
    format!("scene.{}s[{index}]", kind.name())
}

/// Refuses a name that is not among those of its kind in the files.
fn check_name(key: &str, kind: &str, name: Option<&str>, known: &[String]) -> Result<(), Invalid> {
    let Some(name) = name.filter(|name| !known.iter().any(|known| known == name)) else { return Ok(()) };
    let names = || known.iter().map(String::as_str);
    let message = format!("the geometry has no {kind} {name:?}{}", did_you_mean(name, names()));
    let help = match known {
        [] => "its files have none; remove the key".to_owned(),
        _ => format!("its {key}s are {}", list(name, names())),
    };
    Err(Invalid::new(format!("scene.{key}"), message).help(help))
}

/// Coordinates beyond this have squares, such as areas, that come close to the largest number of single precision.
const FARTHEST_M: f64 = 1e18;

/// Smaller radii and lengths, m, have squares without digits of single precision.
const SMALLEST_SIZE_M: f64 = 1e-15;

/// Whether all geometry lies within [`FARTHEST_M`] of the origin along each axis.
fn within_reach(scene: &SceneDescription) -> bool {
    let largest = |mesh: &MeshDescription| mesh.positions.iter().fold(Vec3::ZERO, |max, p| max.max(p.abs()));
    let extents: Vec<DVec3> = scene.meshes.iter().map(|mesh| largest(mesh).as_dvec3()).collect();
    scene.instances.iter().all(|instance| {
        let DAffine3 { matrix3: m, translation } = instance.to_world;
        let turned = DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs()) * extents[instance.mesh];
        (turned + translation.abs()).max_element() <= FARTHEST_M
    })
}

/// Length of the unit of files that have none, m.
fn unit_length(table: &SceneTable) -> Result<f64, Invalid> {
    let scale = table.meters_per_unit.unwrap_or(1.0);
    if scale.is_finite() && scale > 0.0 {
        return Ok(scale);
    }
    let message = format!("must be above 0, got {scale}");
    Err(Invalid::new("meters_per_unit", message).help("for example meters_per_unit = 0.001 for millimetres"))
}

/// Whether there is any light.
fn shines(scene: &SceneDescription) -> bool {
    let shining_mesh = scene.meshes.iter().any(|mesh| scene.materials[mesh.material].emission.is_some());
    scene.environment.is_some() || !scene.lights.is_empty() || shining_mesh
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
