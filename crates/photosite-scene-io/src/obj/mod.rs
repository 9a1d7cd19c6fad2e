//! OBJ geometry with MTL materials, as a [`SceneDescription`].
//!
//! An `.obj` file, with the material libraries and images that it names, becomes meshes in the file's own unit, one for
//! each material of each object, at the origin, and materials as described in the MTL file.
//!
//! Concave polygons, continued lines, smoothing groups, colours of vertices and the options of textures are followed;
//! curves, free-form surfaces and groups (`g`) are not. The parser is our own because files of this format are often
//! wrong in small ways, and a message is of use only with a line number. A test compares it with that of the `tobj`
//! crate on what both can read.

mod colours;
mod files;
mod geometry;
mod lines;
mod map;
mod material;
mod material_textures;
mod mesh;
mod mtl;

#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::assemble::{add_meshes, undescribed};
use super::mesh::MissingNormals;
use files::{file_beside, read_text};
use geometry::Geometry;
use material::describe;
use material_textures::ImageCache;
use mtl::MtlMaterial;
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Result, Sandbox, memory};
use photosite_transport::scene::description::SceneDescription;

/// Content of an OBJ file.
#[derive(Debug)]
pub struct ObjFile {
    /// Scene described by the file.
    pub scene: SceneDescription,
    /// Materials that faces use but no library describes; these are diffuse grey in the scene. A capture file may
    /// describe them, so they are not yet worth a warning.
    pub undescribed_materials: Vec<String>,
}

/// Refuses geometry that takes more memory than there is: corners and triangles, parsed and kept.
fn check_memory(text: &str) -> Result<(), Invalid> {
    /// Bytes of a triangle with its share of the corners, by measurement.
    const TRIANGLE: u64 = 210;
    /// Largest memory per byte of text: the shortest face is "f 1 2 3".
    const MOST: u64 = 32;
    // Seldom is it close enough to be counted.
    if memory::left().is_none_or(|left| text.len() as u64 * MOST <= left.bytes()) {
        return Ok(());
    }
    let triangles_of = |line: &str| {
        let face = line.trim_start().strip_prefix("f ").unwrap_or_default();
        face.split_ascii_whitespace().count().saturating_sub(2) as u64
    };
    let triangles: u64 = text.lines().map(triangles_of).sum();
    memory::check(triangles * TRIANGLE, &format!("its geometry of {triangles} triangles"), "simplify it")
}

/// Options for reading a file.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// Normals for faces without any.
    pub missing_normals: MissingNormals,
    /// Sandbox that materials and their images must lie in.
    pub sandbox: Sandbox,
    /// Whether an image that is missing or broken gets a stand-in with a warning.
    pub is_lenient: bool,
}

/// Reads an `.obj` file with its materials.
pub fn read(path: &Path, choice: &Choice) -> Result<ObjFile> {
    parse(&read_text(path)?, path, choice)
}

/// Reads the text of an `.obj` file; `path` is for messages and for the files that the text refers to.
pub fn parse(text: &str, path: &Path, choice: &Choice) -> Result<ObjFile> {
    check_memory(text).map_err(|invalid| invalid.in_file(path))?;
    let mut warnings = Warnings::default();
    let geometry = Geometry::parse(text, path, &mut warnings)?;
    let libraries = read_libraries(&geometry, path, &choice.sandbox, &mut warnings)?;

    let mut scene = SceneDescription::default();
    let mut images = ImageCache::within(&choice.sandbox, choice.is_lenient);
    for name in &geometry.materials {
        scene.materials.push(match libraries.get(name) {
            Some((library, mtl)) => describe(mtl, images.of_material(mtl, library)?, &mut warnings),
            None => undescribed(name),
        });
    }
    let default_material = scene.materials.len();
    scene.materials.push(undescribed("default"));
    let mut meshes = mesh::meshes(&geometry, choice.missing_normals);
    let is_described: Vec<bool> = geometry.materials.iter().map(|name| libraries.contains_key(name)).collect();
    let coloured = colours::settle(&mut meshes, &mut scene.materials, &is_described, &mut warnings);
    let is_undescribed = |(i, _): &(usize, &String)| !is_described[*i] && !coloured.contains(i);
    let undescribed_materials = geometry.materials.iter().enumerate().filter(is_undescribed);
    let undescribed_materials = undescribed_materials.map(|(_, name)| name.clone()).collect();
    add_meshes(&mut scene, meshes, path, &mut warnings)?;
    if scene.meshes.iter().all(|mesh| mesh.material != default_material) {
        scene.materials.truncate(default_material);
    }
    images.warnings.into_messages().into_iter().for_each(|message| warnings.once(message));
    let libraries = libraries.into_values().map(|(path, _)| path);
    scene.files = libraries.chain(images.slots.into_keys().map(|(path, _)| path)).collect();
    // Something may stand for an image that is missing.
    scene.files.retain(|path| path.is_file());
    scene.files.sort();
    scene.files.dedup();
    scene.images = images.images;
    scene.warnings = warnings.of_file(path);
    Ok(ObjFile { scene, undescribed_materials })
}

/// Materials by name, each with the path of its library. The first description of a name counts.
fn read_libraries(
    geometry: &Geometry,
    file: &Path,
    sandbox: &Sandbox,
    warnings: &mut Warnings,
) -> Result<HashMap<String, (PathBuf, MtlMaterial)>> {
    let mut known = HashMap::new();
    let folder = file.parent().unwrap_or(Path::new(""));
    for (line, names) in &geometry.libraries {
        let allowed =
            |path: &Path| sandbox.check(path).map_err(|invalid| invalid.within("mtllib").at_line(file, *line));
        // A statement may list several files, or name one with blanks in its name.
        let whole = file_beside(folder, names);
        let paths = if whole.exists() && (allowed(&whole).is_ok() || !names.contains(char::is_whitespace)) {
            vec![whole]
        } else {
            names.split_whitespace().map(|n| file_beside(folder, n)).collect()
        };
        for path in paths {
            allowed(&path)?;
            if !path.exists() {
                warnings.once(format!("line {line}: the material library {} is missing", path.display()));
                continue;
            }
            for material in mtl::parse(&read_text(&path)?, &path, warnings)? {
                known.entry(material.name.clone()).or_insert_with(|| (path.clone(), material));
            }
        }
    }
    Ok(known)
}
