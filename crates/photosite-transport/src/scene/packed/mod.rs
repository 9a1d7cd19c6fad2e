//! Scene as plain data, for devices: tables of 16-byte words and of numbers, with no pointers between them.
//!
//! | table | holds |
//! |---|---|
//! | [`nodes`](PackedScene::nodes), [`triangles`](PackedScene::triangles) | hierarchies ([`geometry::packed`](crate::geometry::packed)) |
//! | [`tables`](PackedScene::tables) | records of a fixed number of words each, at the places of [`Sections`] |
//! | [`attributes`](PackedScene::attributes) | corners, normals, tangents, texture coordinates; cumulative sums of an environment; profiles of lights; albedos |
//! | [`spectra`](PackedScene::spectra) | spectra, value and rise at each nanometre |
//! | [`texels`](PackedScene::texels) | images as they are stored |
//!
//! [`materials`], [`layers`] and [`lights`](crate::light::packed) have the words of the records.

pub mod layers;
pub mod materials;
mod words;

pub use crate::bsdf::albedo_tables as albedos;
pub use crate::geometry::packed::{self as hierarchy, NONE, Word};
pub use crate::light::packed as lights;
pub use crate::texture::packed::TEXTURE_WORDS;

use super::Scene;
use crate::bsdf::albedo_tables::AlbedoSections;
use crate::geometry::packed::PackedAccel;
use crate::geometry::{Geometry, MeshRange};
use crate::light::packed::PackedLights;
use crate::texture::packed::PackedTextures;
use photosite_core::Invalid;
use photosite_core::spectrum::upsampling;

/// Words of a mesh: material, first light, first triangle, number of primitives before its own; numbers to subtract
/// from a corner's for normals, tangents and both sets of texture coordinates; that for colours, and of a mesh that
/// changes its shape that for the normals of its shapes, the number of its corners, and that of the parts of the time.
pub const MESH_WORDS: usize = 3;

/// Places of the records of each kind in the tables, in words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sections {
    /// Instances, [`INSTANCE_WORDS`](hierarchy::INSTANCE_WORDS) each.
    pub instances: u32,
    /// Quadrics, [`QUADRIC_WORDS`](hierarchy::QUADRIC_WORDS) each.
    pub quadrics: u32,
    /// Meshes, [`MESH_WORDS`] each.
    pub meshes: u32,
    /// Materials, [`MATERIAL_WORDS`](materials::MATERIAL_WORDS) each.
    pub materials: u32,
    /// Textures, [`TEXTURE_WORDS`] each.
    pub textures: u32,
    /// Lights, [`LIGHT_WORDS`](lights::LIGHT_WORDS) each.
    pub lights: u32,
    /// Nodes of the light tree, [`TREE_WORDS`](lights::TREE_WORDS) each.
    pub tree: u32,
    /// Bins of the choice among lights infinitely far, a word each.
    pub distant: u32,
    /// The sky, if it is the environment.
    pub sky: u32,
    /// Nodes of the table of upsampled colours, a word each.
    pub colours: u32,
    /// Layers that extensions of glTF add to materials, [`LAYER_WORDS`](layers::LAYER_WORDS) each.
    pub layers: u32,
    /// Keys of motions, [`KEY_WORDS`](hierarchy::KEY_WORDS) each, with roots and corners of what changes its shape;
    /// [`NONE`] where nothing moves or changes its shape.
    pub motions: u32,
}

/// Places of the numbers of each kind among the attributes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AttributeSections {
    /// Indices of the corners of each triangle.
    pub corners: u32,
    /// Shading normals, three numbers each.
    pub normals: u32,
    /// Tangents, four numbers each.
    pub tangents: u32,
    /// Colours, four numbers each.
    pub vertex_colours: u32,
    /// Both sets of texture coordinates, two numbers each.
    pub uvs: [u32; 2],
    /// Cumulative sums of the environment's distribution: of its rows, then those of each row.
    pub environment: u32,
    /// Albedos of lobes.
    pub albedos: AlbedoSections,
    /// Profiles of lights: vertical angles, horizontal angles, intensities of each.
    pub profiles: u32,
}

/// Scene as plain data; see the module.
#[derive(Clone, Debug, Default)]
pub struct PackedScene {
    /// Nodes of all hierarchies.
    pub nodes: Vec<Word>,
    /// Triangles in the order of the leaves.
    pub triangles: Vec<Word>,
    /// Child that all begins with; [`NONE`] without geometry.
    pub root: u32,
    /// Records.
    pub tables: Vec<Word>,
    /// Places of the records.
    pub sections: Sections,
    /// Numbers of vertices and of distributions.
    pub attributes: Vec<u32>,
    /// Places of the numbers.
    pub attribute_sections: AttributeSections,
    /// Values of spectra and their rises to the next.
    pub spectra: Vec<[f32; 2]>,
    /// Texels.
    pub texels: Vec<u32>,
    /// Numbers that choose lights, and the environment.
    pub lights: PackedLights,
    /// Whether any material has holes by alpha.
    pub has_holes: bool,
    /// Features of the scene, which kernels are compiled for, see [`flag`](layers::flag).
    pub features: u32,
}

impl Scene {
    /// Packs the scene.
    ///
    /// # Errors
    ///
    /// Hierarchies that are deeper, or hold more, than the numbers of the packed form can tell.
    pub fn packed(&self) -> Result<PackedScene, Invalid> {
        let PackedAccel { nodes, triangles, quadrics, instances, mut motions, root } =
            self.accel.packed(&self.geometry)?;
        let mut textures = PackedTextures::default();
        for texture in &self.textures {
            textures.add(texture);
        }
        let (lights, light_tables) = self.lights.packed(&self.geometry, &mut textures, &mut motions);
        let (materials, packed_layers) = self.packed_materials();
        let mut tables = Vec::new();
        let mut section = |words: Vec<Word>| {
            let first = tables.len() as u32;
            tables.extend(words);
            first
        };
        let has_colours = !textures.words.is_empty() || !self.geometry.colours.is_empty();
        let colours = if has_colours { upsampling::table_words() } else { Vec::new() };
        let sections = Sections {
            instances: section(instances),
            quadrics: section(quadrics),
            meshes: section(mesh_words(&self.geometry)),
            materials: section(materials),
            textures: section(textures.words),
            lights: section(light_tables.lights),
            tree: section(light_tables.tree),
            distant: section(light_tables.distant),
            sky: section(light_tables.sky),
            colours: section(colours),
            layers: section(packed_layers.words),
            motions: if motions.is_empty() { NONE } else { section(motions) },
        };
        let (attributes, attribute_sections) =
            attributes(&self.geometry, [light_tables.environment, light_tables.profiles], packed_layers.flags);
        Ok(PackedScene {
            nodes,
            triangles,
            root: root.unwrap_or(NONE),
            tables,
            sections,
            attributes,
            attribute_sections,
            spectra: self.spectra.entries().to_vec(),
            texels: textures.texels,
            lights,
            has_holes: self.has_alpha,
            // Each material has it with its own words.
            features: packed_layers.flags & !layers::flag::DISPERSIVE
                | if self.has_panes && self.lights.has_deltas() { layers::flag::PANES } else { 0 },
        })
    }
}

/// Words of all meshes. Normals of meshes that change their shape follow those of all others.
fn mesh_words(geometry: &Geometry) -> Vec<Word> {
    let number = |number: Option<u32>| number.unwrap_or(NONE);
    let mut first_normal = geometry.normals.len() as u32;
    let words = |mesh: &MeshRange| {
        let [first, second] = mesh.uvs_from.map(number);
        let changing = match mesh.deformation {
            None => [0; 3],
            Some(deformation) => {
                let deformation = &geometry.deformations[deformation as usize];
                let normals_from = deformation.first_corner.wrapping_sub(first_normal);
                first_normal += deformation.normals.len() as u32;
                [normals_from, deformation.corner_count, deformation.shape_count() as u32 - 1]
            }
        };
        let [normals_from, corners, parts] = changing;
        [
            [mesh.material, number(mesh.first_light), mesh.first_triangle, mesh.first_primitive],
            [number(mesh.normals_from), number(mesh.tangents_from), first, second],
            [number(mesh.colours_from), normals_from, corners, parts],
        ]
    };
    geometry.meshes.iter().flat_map(words).collect()
}

/// Numbers of vertices, of lights and of lobes, and the places of each kind.
fn attributes(geometry: &Geometry, lights: [Vec<f32>; 2], features: u32) -> (Vec<u32>, AttributeSections) {
    let [environment, profiles] = lights;
    let Geometry { normals, tangents, uvs, colours, triangles, .. } = geometry;
    let has_none = normals.is_empty() && tangents.is_empty() && colours.is_empty() && uvs.iter().all(Vec::is_empty);
    let mut all: Vec<u32> = Vec::new();
    let mut section = |numbers: &mut dyn Iterator<Item = u32>| {
        let first = all.len() as u32;
        all.extend(numbers);
        first
    };
    let changing = geometry.deformations.iter().flat_map(|deformation| &deformation.normals);
    // Corners are looked up for the sake of these alone
    let corners = triangles.iter().flat_map(|triangle| triangle.corners);
    let sections = AttributeSections {
        corners: section(&mut corners.filter(|_| !has_none)),
        normals: section(&mut normals.iter().chain(changing).flat_map(|v| v.to_array()).map(f32::to_bits)),
        tangents: section(&mut tangents.iter().flat_map(|v| v.to_array()).map(f32::to_bits)),
        vertex_colours: section(&mut colours.iter().flat_map(|v| v.to_array()).map(f32::to_bits)),
        uvs: [0, 1].map(|set| section(&mut uvs[set].iter().flat_map(|v| v.to_array()).map(f32::to_bits))),
        environment: section(&mut environment.into_iter().map(f32::to_bits)),
        profiles: section(&mut profiles.into_iter().map(f32::to_bits)),
        albedos: AlbedoSections::of(features, |numbers| section(&mut numbers.into_iter().map(f32::to_bits))),
    };
    (all, sections)
}
