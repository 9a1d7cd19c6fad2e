//! How large a scene is, and whether that looks like another unit than the metre.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::geometry_kind::GeometryKind;
use super::input::is_scene_file;
use super::source::CaptureSource;
use super::tables::SceneTable;
use crate::Result;
use crate::geometry::QuadricKind;
use crate::math::float::rounded;
use crate::scene::description::{InstanceDescription, MeshDescription, SceneDescription};

/// Longest side of what files without a unit hold, m: what is longer looks like millimetres, of which that would be two
/// centimetres, or like centimetres or inches.
const LONGEST_M: f64 = 20.0;

/// The same of glTF files, m, which are in metres, as few programs know that write them.
const LONGEST_OF_GLTF_M: f64 = 100.0;

/// A box along the axes, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
}

impl Extent {
    /// That of all instances of the subject; `None` without any.
    pub(crate) fn of_scene(scene: &SceneDescription) -> Option<Self> {
        Self::around(subject(scene).filter_map(|instance| Self::of_instance(scene, instance)))
    }

    /// That of an instance where it is first.
    pub(crate) fn of_instance(scene: &SceneDescription, instance: &InstanceDescription) -> Option<Self> {
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
    pub(crate) fn size(&self) -> DVec3 {
        self.high - self.low
    }
}

/// All instances but those that surround the subject, as a ground out to the horizon does.
pub(crate) fn subject(scene: &SceneDescription) -> impl Iterator<Item = &InstanceDescription> {
    let is_subject = |(index, _): &(usize, &InstanceDescription)| !scene.surroundings.contains(index);
    scene.instances.iter().enumerate().filter(is_subject).map(|(_, instance)| instance)
}

/// A file of geometry and its unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FileUnit {
    /// As the capture names it.
    pub(crate) file: String,
    /// m.
    pub(crate) unit_m: f64,
    /// Who says so.
    pub(crate) source: UnitSource,
}

/// Who says what the unit of a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnitSource {
    /// The kind of file.
    Gltf,
    /// The capture's `meters_per_unit`.
    Capture,
    /// Nobody.
    Assumed,
}

impl UnitSource {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Gltf => "glTF",
            Self::Capture => "meters_per_unit",
            Self::Assumed => "assumed",
        }
    }
}

/// The geometry files of a capture with their units, each once.
pub(super) fn units(source: &CaptureSource) -> Result<Vec<FileUnit>> {
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
pub(super) fn unit_warning(scene: &SceneDescription, source: &CaptureSource) -> Option<String> {
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
