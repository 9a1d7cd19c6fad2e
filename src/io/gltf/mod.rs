//! glTF 2.0 and its binary form GLB, as a [`SceneDescription`].
//!
//! In: a file and what it refers to. Out: meshes in metres, materials, textures, lights (candela, lux, nit) and cameras
//! in world axes. The document is parsed by the `gltf` crate's JSON types; everything that they refer to by index,
//! offset or count is checked here, since files come damaged and the crate's own accessors trust them.
//!
//! Left to others: tangents where they are missing ([`complete`](super::complete)), colours as spectra, and every
//! extension but those in [`SUPPORTED_EXTENSIONS`].

mod accessor;
mod buffers;
mod extensions;
mod glb;
mod instancing;
mod light;
mod material;
mod mesh;
mod nodes;
mod skin;
mod texture;
mod variants;

#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs;
use std::ops::Range;
use std::path::Path;

use glam::DAffine3;
use gltf::json::Root;

use super::json::located;
use super::warnings::Warnings;
use crate::scene::description::{InstanceDescription, SceneDescription};
use crate::{Error, Invalid, Result};
use accessor::Accessors;
use buffers::Buffers;
use mesh::{MeshReader, Pose};
use texture::Textures;

/// Extensions that a file may require.
pub const SUPPORTED_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// A glTF file.
#[derive(Debug)]
pub struct GltfFile {
    /// What it describes.
    pub scene: SceneDescription,
    /// Names of its material variants.
    pub variants: Vec<String>,
}

/// Reads a `.gltf` or `.glb` file, with the materials of `variant` where it has a variant of that name.
pub fn read(path: &Path, variant: Option<&str>) -> Result<GltfFile> {
    let bytes = fs::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    read_bytes(&bytes, path, variant)
}

/// Reads a document from memory; `path` is for messages and for what the document refers to.
pub(super) fn read_bytes(bytes: &[u8], path: &Path, variant: Option<&str>) -> Result<GltfFile> {
    let is_glb = glb::is_glb(bytes);
    let (json, chunk) =
        if is_glb { glb::split(bytes).map_err(|invalid| invalid.in_file(path))? } else { (bytes, None) };
    let root: Root = serde_json::from_slice(json).map_err(|error| {
        let text = if error.is_eof() { "it ends too early".to_owned() } else { error.to_string() };
        let problem = text.rsplit_once(" at line ").map_or(&*text, |(problem, _)| problem);
        let invalid = Invalid::new("", format!("is no glTF document: {problem}")).help("export the scene as glTF 2.0");
        // The lines of a binary file are nobody's, not even where its first bytes are missing.
        let is_binary = is_glb || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"));
        if is_binary || json.is_empty() { invalid.in_file(path) } else { invalid.at_line(path, error.line()) }
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let in_text = |invalid| if is_glb { Invalid::in_file(invalid, path) } else { located(invalid, path, json) };
    let read = || {
        check(&root)?;
        let variants = variants::names(&root)?;
        let chosen = variant.and_then(|variant| variants.iter().position(|name| name == variant));
        let (scene, warnings) = convert(&root, chunk, folder, chosen)?;
        Ok((GltfFile { scene, variants }, warnings))
    };
    read().map_err(in_text).map(|(mut file, warnings)| {
        file.scene.warnings = warnings.of_file(path);
        file
    })
}

/// Checks what a document needs from a reader.
fn check(root: &Root) -> Result<(), Invalid> {
    let version = root.asset.min_version.as_ref().unwrap_or(&root.asset.version);
    if !version.starts_with("2.") || root.asset.min_version.as_ref().is_some_and(|v| v != "2.0") {
        return Err(Invalid::new("asset.version", format!("glTF {version} is not supported"))
            .help("export the scene as glTF 2.0"));
    }
    for (i, name) in root.extensions_required.iter().enumerate() {
        if !SUPPORTED_EXTENSIONS.contains(&name.as_str()) {
            let message = format!("the file requires the extension {name}, which is not supported");
            return Err(Invalid::new(format!("extensionsRequired[{i}]"), message)
                .help(format!("export without it; supported are {}", SUPPORTED_EXTENSIONS.join(", "))));
        }
    }
    Ok(())
}

fn convert(
    root: &Root,
    chunk: Option<&[u8]>,
    folder: &Path,
    variant: Option<usize>,
) -> Result<(SceneDescription, Warnings), Invalid> {
    let mut warnings = Warnings::default();
    for name in root.extensions_used.iter().filter(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str())) {
        warnings.once(format!("the extension {name} is not supported and is ignored"));
    }
    let buffers = Buffers::load(root, chunk, folder)?;
    let accessors = Accessors { root, buffers: &buffers };
    let mut scene = SceneDescription::default();

    let mut textures = Textures::new(root);
    for (i, material) in root.materials.iter().enumerate() {
        scene.materials.push(material::read_material(material, i, &mut textures, &mut warnings)?);
    }
    let default_material = scene.materials.len();
    scene.materials.push(material::default_material());

    let placed = nodes::placed_nodes(root)?;
    let mut to_world = vec![None; root.nodes.len()];
    for node in &placed {
        to_world[node.index] = Some(node.to_world);
    }
    let reader = MeshReader { accessors, default_material, variant };
    // glTF mesh in its own shape → the descriptions of its primitives, read once however often it is placed.
    let mut meshes: HashMap<usize, Range<usize>> = HashMap::new();
    let mut zero_area = 0;
    for placed in placed {
        scene.cameras.extend(light::read_camera(root, &placed, &mut warnings)?);
        scene.lights.extend(light::read_light(root, &placed, &mut warnings)?);
        let Some(mesh) = placed.node.mesh else { continue };
        let key = format!("nodes[{}].mesh", placed.index);
        let joints = match placed.node.skin {
            Some(skin) => {
                let key = format!("nodes[{}].skin", placed.index);
                Some(skin::joints(accessors, skin.value(), &key, &to_world)?)
            }
            None => None,
        };
        let pose = Pose { weights: placed.node.weights.as_deref(), joints: joints.as_deref() };
        let mut read = |warnings: &mut Warnings| {
            let (read, mended) = mesh::read_mesh(&reader, mesh.value(), &key, pose, warnings)?;
            zero_area += mended.zero_area;
            if mended.normals > 0 {
                warnings.once("some normals have no length and were computed from the triangles around them");
            }
            let first = scene.meshes.len();
            scene.meshes.extend(read);
            Ok::<_, Invalid>(first..scene.meshes.len())
        };
        let primitives = if pose.is_own() {
            match meshes.entry(mesh.value()) {
                Entry::Occupied(known) => known.get().clone(),
                Entry::Vacant(new) => new.insert(read(&mut warnings)?).clone(),
            }
        } else {
            read(&mut warnings)?
        };
        // The joints of a skin stand in the world; where its mesh does is of no importance (§3.7.3.3).
        let places = match joints {
            Some(_) => vec![DAffine3::IDENTITY],
            None => instancing::placements(accessors, &placed)?,
        };
        for to_world in places {
            let place = |mesh| InstanceDescription { name: placed.name.clone(), mesh, to_world };
            scene.instances.extend(primitives.clone().map(place));
        }
    }
    if zero_area > 0 {
        warnings.once(super::zero_area_message(zero_area));
    }
    if scene.meshes.iter().all(|mesh| mesh.material != default_material) {
        scene.materials.truncate(default_material);
    }
    scene.images = textures.decode(&buffers, folder)?;
    Ok((scene, warnings))
}
