//! glTF 2.0 and its binary form GLB, as a [`SceneDescription`].
//!
//! A file and the files that it refers to become meshes in metres, materials, textures, lights (candela, lux, nit) and
//! cameras in world axes. The document is parsed by the `gltf` crate's JSON types; every index, offset and count in
//! them is checked here, since files may be damaged and the crate's own accessors trust them.
//!
//! Left to others: tangents where they are missing ([`complete`](super::complete)), colours as spectra, and every
//! extension but those in [`SUPPORTED_EXTENSIONS`].

mod accessor;
mod animation;
mod buffers;
mod cameras_and_lights;
mod contained;
mod document;
mod draco;
mod extensions;
mod glb;
mod instancing;
mod ktx2;
mod material;
mod mesh;
mod meshopt;
mod nodes;
mod skin;
mod texture;
mod unpacked;
mod variants;

#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DAffine3;
use gltf::json::Root;
use gltf::json::scene::Node;
use gltf::json::validation::Checked;

use accessor::Accessors;
pub use animation::Moment;
use buffers::{Buffers, FileLocation};
use document::Document;
use mesh::{MeshReader, Pose};
use photosite_core::input;
use photosite_core::json::located;
use photosite_core::warnings::Warnings;
use photosite_core::{Error, Invalid, Result, Sandbox, memory, text};
use photosite_transport::scene::description::{
    CameraDescription, InstanceDescription, LightDescription, SceneDescription,
};
use texture::Textures;

/// Extensions that a file may require.
pub const SUPPORTED_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
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
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// A glTF file.
#[derive(Debug)]
pub struct GltfFile {
    /// Scene described by the file.
    pub scene: SceneDescription,
    /// Names of its material variants.
    pub variants: Vec<String>,
    /// Names of its animations.
    pub animations: Vec<String>,
}

/// Selection of parts of a file, and limits of reading it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Choice<'a> {
    /// Variant whose materials are used, where the file has one of that name.
    pub variant: Option<&'a str>,
    /// Moment of the animation; without it, poses are those of the file.
    pub moment: Option<&'a Moment>,
    /// Sandbox that named files must lie in, if any.
    pub sandbox: Option<&'a Sandbox>,
    /// Whether a texture that is missing or broken gets a stand-in with a warning.
    pub is_lenient: bool,
}

/// Reads a `.gltf` or `.glb` file.
pub fn read(path: &Path, choice: Choice<'_>) -> Result<GltfFile> {
    let bytes = input::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    read_bytes(&bytes, path, choice)
}

/// Reads a document from memory; `path` is for messages and for what the document refers to.
pub fn read_bytes(bytes: &[u8], path: &Path, choice: Choice<'_>) -> Result<GltfFile> {
    let is_glb = glb::is_glb(bytes);
    let (json, chunk) =
        if is_glb { glb::split(bytes).map_err(|invalid| invalid.in_file(path))? } else { (bytes, None) };
    let json = &*text::plain(json).map_err(|reason| Error::io(path, "read", reason))?;
    // The lines of a binary file are nobody's, not even where its first bytes are missing.
    let is_binary = is_glb || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"));
    let document = Document::parse(json, path, !is_binary && !json.is_empty())?;
    let root = &document.root;
    let place = FileLocation { folder: path.parent().unwrap_or(Path::new("")), sandbox: choice.sandbox };
    let in_text = |invalid| if is_glb { Invalid::in_file(invalid, path) } else { located(invalid, path, json) };
    let read = || {
        check(root)?;
        let variants = variants::names(root)?;
        let chosen = choice.variant.and_then(|variant| variants.iter().position(|name| name == variant));
        let mut warnings = Warnings::default();
        document.say_what_stands_still(|what| warnings.once(what))?;
        let scene = convert(root, chunk, place, chosen, choice, &mut warnings)?;
        Ok((GltfFile { scene, variants, animations: animation::names(root) }, warnings))
    };
    read().map_err(in_text).map(|(mut file, warnings)| {
        file.scene.warnings = warnings.of_file(path);
        file.scene.files = named_files(root, place);
        file
    })
}

/// Files that a document names, each once. Required data without a file is an error before this.
fn named_files(root: &Root, place: FileLocation<'_>) -> Vec<PathBuf> {
    let buffers = root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
    let images = root.images.iter().filter_map(|image| image.uri.as_deref());
    let mut files: Vec<PathBuf> = buffers.chain(images).filter_map(|uri| buffers::path_of(uri, place.folder)).collect();
    files.retain(|path| place.sandbox.is_none_or(|sandbox| sandbox.check(path).is_ok()) && path.is_file());
    files.sort();
    files.dedup();
    files
}

/// Checks that the version and the required extensions of a document are supported.
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

/// Refuses geometry that takes more memory than there is: corners and triangles of buffers that exist, read, checked
/// and kept.
fn check_memory(root: &Root) -> Result<(), Invalid> {
    /// Bytes of a number, three times over.
    const NUMBER: u64 = 3 * 4;
    // What nothing backs is told in its place; a number has a byte at least.
    let most = root.buffers.iter().map(|buffer| buffer.byte_length.0).fold(0, u64::saturating_add);
    let numbers = |accessor: &gltf::json::Accessor| match accessor.type_ {
        Checked::Valid(kind) => accessor.count.0.saturating_mul(kind.multiplicity() as u64).min(most),
        Checked::Invalid => 0,
    };
    let all = root.accessors.iter().map(numbers).fold(0, u64::saturating_add);
    let invalid = memory::check(all.saturating_mul(NUMBER), "its geometry", "simplify the scene");
    invalid.map_err(|invalid| invalid.within("accessors"))
}

fn convert(
    root: &Root,
    chunk: Option<&[u8]>,
    place: FileLocation<'_>,
    variant: Option<usize>,
    choice: Choice<'_>,
    warnings: &mut Warnings,
) -> Result<SceneDescription, Invalid> {
    for name in root.extensions_used.iter().filter(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str())) {
        warnings.once(format!("the extension {name} is not supported and is ignored"));
    }
    let buffers = Buffers::load(root, chunk, place)?;
    let accessors = Accessors { root, buffers: &buffers, unpacked: None };
    check_memory(root)?;
    let mut scene = SceneDescription::default();

    let mut textures = Textures::new(root);
    for (i, material) in root.materials.iter().enumerate() {
        scene.materials.push(material::read_material(material, i, &mut textures, warnings)?);
    }
    let default_material = scene.materials.len();
    scene.materials.push(material::default_material());

    let poses = animation::poses(accessors, choice.moment, warnings)?;
    let times = poses.iter().map(|nodes| Moved::new(root, nodes)).collect::<Result<Vec<_>, _>>()?;
    let reader = MeshReader { accessors, default_material, variant };
    // glTF mesh in its own shape → the descriptions of its primitives, read once however often it is placed.
    let mut meshes: HashMap<usize, Range<usize>> = HashMap::new();
    let mut zero_area = 0;
    for (i, placed) in times[0].placed.iter().enumerate() {
        // The node at all times.
        let always = || times.iter().map(|time| &time.placed[i]);
        let later: Vec<DAffine3> = always().skip(1).map(|placed| nodes::rigid(&placed.to_world)).collect();
        let camera = cameras_and_lights::read_camera(root, placed, warnings)?;
        scene.cameras.extend(camera.map(|camera| CameraDescription { later: later.clone(), ..camera }));
        // Cameras stay where things are hidden.
        if !placed.is_visible {
            continue;
        }
        let light = cameras_and_lights::read_light(root, placed, warnings)?;
        scene.lights.extend(light.map(|light| LightDescription { later, ..light }));
        let Some(mesh) = placed.node.mesh else { continue };
        let key = format!("nodes[{}].mesh", placed.index);
        let mut joints = Vec::new();
        if let Some(skin) = placed.node.skin {
            let key = format!("nodes[{}].skin", placed.index);
            for time in &times {
                joints.push(skin::joints(accessors, skin.value(), &key, &time.to_world)?);
            }
        }
        let pose = |(time, placed): (usize, &nodes::PlacedNode<'_>)| Pose {
            weights: placed.node.weights.clone(),
            joints: joints.get(time).map(Vec::as_slice),
        };
        let mut poses: Vec<Pose<'_>> = always().enumerate().map(pose).collect();
        if poses.iter().all(|pose| *pose == poses[0]) {
            poses.truncate(1);
        }
        let mut read = |warnings: &mut Warnings| {
            let (read, mended) = mesh::read_mesh(&reader, mesh.value(), &key, &poses, warnings)?;
            zero_area += mended.zero_area;
            if mended.normals > 0 {
                warnings.once("some normals have no length and were computed from the triangles around them");
            }
            let first = scene.meshes.len();
            scene.meshes.extend(read.into_iter().map(Arc::new));
            Ok::<_, Invalid>(first..scene.meshes.len())
        };
        let primitives = if poses.iter().all(Pose::is_own) {
            match meshes.entry(mesh.value()) {
                Entry::Occupied(known) => known.get().clone(),
                Entry::Vacant(new) => new.insert(read(warnings)?).clone(),
            }
        } else {
            read(warnings)?
        };
        // The joints of a skin stand in the world; where its mesh does is of no importance (§3.7.3.3).
        let places = |placed| match joints[..] {
            [] => instancing::placements(accessors, placed),
            _ => Ok(vec![DAffine3::IDENTITY]),
        };
        let (first, later) = (places(placed)?, always().skip(1).map(places).collect::<Result<Vec<_>, _>>()?);
        for (p, to_world) in first.into_iter().enumerate() {
            let place = |mesh| {
                let later = later.iter().map(|places| places[p]).collect();
                InstanceDescription { later, ..InstanceDescription::of_mesh(&placed.name, mesh, to_world) }
            };
            scene.instances.extend(primitives.clone().map(place));
        }
    }
    if zero_area > 0 {
        warnings.once(super::zero_area_message(zero_area));
    }
    if scene.meshes.iter().all(|mesh| mesh.material != default_material) {
        scene.materials.truncate(default_material);
    }
    scene.images = textures.decode(&buffers, place, choice.is_lenient, warnings)?;
    Ok(scene)
}

/// Transforms of all nodes at a time.
struct Moved<'a> {
    /// Nodes of the scene, in the same order at every time.
    placed: Vec<nodes::PlacedNode<'a>>,
    /// Node → world by index, if it is in the scene.
    to_world: Vec<Option<DAffine3>>,
}

impl<'a> Moved<'a> {
    fn new(root: &Root, nodes: &'a [Node]) -> Result<Self, Invalid> {
        let placed = nodes::placed_nodes(root, nodes)?;
        let mut to_world = vec![None; nodes.len()];
        for node in &placed {
            to_world[node.index] = Some(node.to_world);
        }
        Ok(Self { placed, to_world })
    }
}
