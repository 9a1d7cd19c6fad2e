//! Extent of a scene, and whether it looks like another unit than the metre.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::super::files::input::is_scene_file;
use super::super::tables::SceneTable;
use super::super::tables::geometry_kind::GeometryKind;
use super::super::tree::source::CaptureSource;
use photosite_core::Result;
use photosite_core::math::float::rounded;
use photosite_transport::geometry::QuadricKind;
use photosite_transport::scene::description::{InstanceDescription, MeshDescription, SceneDescription};

/// Longest side of the contents of files without a unit, m: longer ones look like millimetres, of which that would be
/// two centimetres, or like centimetres or inches.
const LONGEST_M: f64 = 20.0;

/// Longest side of glTF files, m: they are in metres, but few programs that write them know it.
const LONGEST_OF_GLTF_M: f64 = 100.0;

/// A box along the axes, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Smallest coordinates, m.
    pub low: DVec3,
    /// Largest coordinates, m.
    pub high: DVec3,
}

impl Extent {
    /// Extent of all instances of the subject; `None` without any.
    pub fn of_scene(scene: &SceneDescription) -> Option<Self> {
        Self::around(subject(scene).filter_map(|instance| Self::of_instance(scene, instance)))
    }

    /// Extent of an instance where it is first.
    pub fn of_instance(scene: &SceneDescription, instance: &InstanceDescription) -> Option<Self> {
        let meshes = scene.meshes[instance.meshes.clone()].iter();
        Self::around(meshes.filter_map(|mesh| Self::of_mesh(mesh, &instance.to_world)))
    }

    fn of_mesh(mesh: &MeshDescription, to_world: &DAffine3) -> Option<Self> {
        if let Some(kind) = mesh.quadric {
            let DMat3 { x_axis: x, y_axis: y, z_axis: z } = to_world.matrix3;
            let middle = to_world.translation;
            // The reach of a ball or of a circle along each axis is the length of the row there.
            let reach = |z: DVec3| (x * x + y * y + z * z).map(f64::sqrt);
            let around = |middle: DVec3, reach: DVec3| Self { low: middle - reach, high: middle + reach };
            return match kind {
                QuadricKind::Sphere => Some(around(middle, reach(z))),
                QuadricKind::Disk => Some(around(middle, reach(DVec3::ZERO))),
                QuadricKind::Cylinder => {
                    let ends = [middle, middle + z].map(|end| around(end, reach(DVec3::ZERO)));
                    Self::around(ends.into_iter())
                }
            };
        }
        let corners = mesh.positions.iter().map(|position| {
            let point = to_world.transform_point3(position.as_dvec3());
            Self { low: point, high: point }
        });
        Self::around(corners)
    }

    /// The box around boxes.
    fn around(boxes: impl Iterator<Item = Self>) -> Option<Self> {
        boxes.reduce(|a, b| Self { low: a.low.min(b.low), high: a.high.max(b.high) })
    }

    /// Lengths of the sides, m.
    pub fn size(&self) -> DVec3 {
        self.high - self.low
    }
}

/// All instances but those that surround the subject, as a ground out to the horizon does.
pub fn subject(scene: &SceneDescription) -> impl Iterator<Item = &InstanceDescription> {
    let is_subject = |(index, _): &(usize, &InstanceDescription)| !scene.surroundings.contains(index);
    scene.instances.iter().enumerate().filter(is_subject).map(|(_, instance)| instance)
}

/// A file of geometry and its unit.
#[derive(Clone, Debug, PartialEq)]
pub struct FileUnit {
    /// Name of the file in the capture.
    pub file: String,
    /// Unit of the file, m.
    pub unit_m: f64,
    /// Source of the unit.
    pub source: UnitSource,
}

/// Source of the unit of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitSource {
    /// Kind of file: glTF has metres.
    Gltf,
    /// The capture's `meters_per_unit`.
    Capture,
    /// No statement: the unit is assumed.
    Assumed,
}

impl UnitSource {
    pub fn name(self) -> &'static str {
        match self {
            Self::Gltf => "glTF",
            Self::Capture => "meters_per_unit",
            Self::Assumed => "assumed",
        }
    }
}

/// The geometry files of a capture with their units, each once.
pub(crate) fn units(source: &CaptureSource) -> Result<Vec<FileUnit>> {
    let table: SceneTable = source.read("scene")?.unwrap_or_default();
    let of_objects = table.objects.into_iter().map(|object| {
        let assumed = if is_in_metres(&object.file) { UnitSource::Gltf } else { UnitSource::Assumed };
        (object.file, object.meters_per_unit, assumed)
    });
    // Of the short form, glTF keeps its own unit.
    let of_geometry = table.geometry.into_iter().map(|file| match is_in_metres(&file) {
        true => (file, None, UnitSource::Gltf),
        false => (file, table.meters_per_unit, UnitSource::Assumed),
    });
    let mut units = Vec::new();
    for (file, stated, otherwise) in of_geometry.chain(of_objects) {
        let source = if stated.is_some() { UnitSource::Capture } else { otherwise };
        let unit = FileUnit { file, unit_m: stated.unwrap_or(1.0), source };
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    Ok(units)
}

fn is_in_metres(file: &str) -> bool {
    GeometryKind::of(Path::new(file)).is_none_or(GeometryKind::is_in_metres)
}

/// Tells that a scene is so large that its unit is hardly the metre: of files without a unit, or of a glTF file that
/// stands for a capture. Of objects with poses it is the largest that counts, not how far they stand apart.
pub(crate) fn unit_warning(scene: &SceneDescription, source: &CaptureSource) -> Option<String> {
    let units = units(source).ok()?;
    let assumed = units.iter().find(|unit| unit.source == UnitSource::Assumed);
    let is_mesh = |instance: &&InstanceDescription| {
        scene.meshes[instance.meshes.clone()].iter().all(|mesh| mesh.quadric.is_none())
    };
    let instances = subject(scene).filter(is_mesh);
    let boxes = instances.filter_map(|instance| Extent::of_instance(scene, instance));
    let size = if source.has("scene.objects") {
        boxes.map(|extent| extent.size()).max_by(|a, b| a.max_element().total_cmp(&b.max_element()))?
    } else {
        Extent::around(boxes)?.size()
    };
    let key = if source.has("scene.objects") { "meters_per_unit of the object" } else { "scene.meters_per_unit" };
    let longest = size.max_element();
    let [x, y, z] = size.to_array().map(|m| rounded(m, 3));
    match assumed {
        Some(FileUnit { file, .. }) if longest > LONGEST_M => Some(format!(
            "the scene is {x} × {y} × {z} m in size, as {file} states no unit and is taken to be in metres: write {key} = 0.001 \
             for millimetres, 0.01 for centimetres, 0.0254 for inches, or 1 if this is right"
        )),
        None if longest > LONGEST_OF_GLTF_M && is_scene_file(source.path()) => Some(format!(
            "the scene is {x} × {y} × {z} m in size, as glTF is in metres: if it is not, export it in metres"
        )),
        Some(_) | None => None,
    }
}
