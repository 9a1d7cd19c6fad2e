//! Scene as plain data, for devices: tables of 16-byte words and of numbers, with no pointers between them.
//!
//! | table | holds |
//! |---|---|
//! | [`nodes`](PackedScene::nodes), [`triangles`](PackedScene::triangles) | hierarchies ([`geometry::packed`](crate::geometry::packed)) |
//! | [`tables`](PackedScene::tables) | records of a fixed number of words each, at the places of [`Sections`] |
//! | [`attributes`](PackedScene::attributes) | corners, normals, tangents, texture coordinates; cumulative sums of an environment; profiles of lights |
//! | [`spectra`](PackedScene::spectra) | spectra, value and rise at each nanometre |
//! | [`texels`](PackedScene::texels) | images as they are stored |
//!
//! Parts of a scene that have no packed form yet are an error that says so; [`materials`] and
//! [`lights`](crate::light::packed) have the tables of what has one.

pub mod materials;

pub use crate::bsdf::ALBEDO_NODES;
pub use crate::geometry::packed::{self as hierarchy, NONE, Word};
pub use crate::light::packed as lights;
pub use crate::texture::packed::TEXTURE_WORDS;

use super::Scene;
use crate::bsdf::albedo_words;
use crate::geometry::packed::PackedAccel;
use crate::geometry::{Geometry, MeshRange};
use crate::light::packed::PackedLights;
use crate::texture::packed::PackedTextures;
use photosite_core::Invalid;
use photosite_core::spectrum::upsampling;

/// Words of a mesh: material, first light, first triangle, number of primitives before its own; numbers to subtract from a corner's
/// for normals, tangents and both sets of texture coordinates; and for colours.
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
    /// Albedos of facets, [`ALBEDO_NODES`] rows of as many nodes and a mean, a word each.
    pub albedos: u32,
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
    /// Whether light of sources without a surface may go straight on through any material.
    pub has_panes: bool,
}

impl Scene {
    /// Packs the scene.
    ///
    /// # Errors
    ///
    /// Something that no packed form has yet.
    pub fn packed(&self) -> Result<PackedScene, Invalid> {
        let PackedAccel { nodes, triangles, quadrics, instances, root } = self.accel.packed(&self.geometry)?;
        let mut textures = PackedTextures::default();
        for texture in &self.textures {
            textures.add(texture);
        }
        let (lights, light_tables) = self.lights.packed(&self.geometry, &mut textures)?;
        let materials = self.packed_materials()?;
        let mut tables = Vec::new();
        let mut section = |words: Vec<Word>| {
            let first = tables.len() as u32;
            tables.extend(words);
            first
        };
        let has_colours = !textures.words.is_empty() || !self.geometry.colours.is_empty();
        let colours = if has_colours { upsampling::table_words() } else { Vec::new() };
        let albedos = if self.layered.is_empty() { Vec::new() } else { albedo_words() };
        let sections = Sections {
            instances: section(instances),
            quadrics: section(quadrics),
            meshes: section(self.geometry.meshes.iter().flat_map(mesh_words).collect()),
            materials: section(materials),
            textures: section(textures.words),
            lights: section(light_tables.lights),
            tree: section(light_tables.tree),
            distant: section(light_tables.distant),
            sky: section(light_tables.sky),
            colours: section(colours),
            albedos: section(albedos),
        };
        let (attributes, attribute_sections) =
            attributes(&self.geometry, light_tables.environment, light_tables.profiles);
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
            has_panes: self.has_panes && self.lights.has_deltas(),
        })
    }
}

fn mesh_words(mesh: &MeshRange) -> [Word; MESH_WORDS] {
    let number = |number: Option<u32>| number.unwrap_or(NONE);
    let [first, second] = mesh.uvs_from.map(number);
    [
        [mesh.material, number(mesh.first_light), mesh.first_triangle, mesh.first_primitive],
        [number(mesh.normals_from), number(mesh.tangents_from), first, second],
        [number(mesh.colours_from), 0, 0, 0],
    ]
}

/// Numbers of vertices, and the places of each kind.
fn attributes(geometry: &Geometry, environment: Vec<f32>, profiles: Vec<f32>) -> (Vec<u32>, AttributeSections) {
    let Geometry { normals, tangents, uvs, colours, triangles, .. } = geometry;
    let has_none = normals.is_empty() && tangents.is_empty() && colours.is_empty() && uvs.iter().all(Vec::is_empty);
    let mut all: Vec<u32> = Vec::new();
    let mut section = |numbers: &mut dyn Iterator<Item = u32>| {
        let first = all.len() as u32;
        all.extend(numbers);
        first
    };
    // Corners are looked up for the sake of these alone
    let corners = triangles.iter().flat_map(|triangle| triangle.corners);
    let sections = AttributeSections {
        corners: section(&mut corners.filter(|_| !has_none)),
        normals: section(&mut normals.iter().flat_map(|v| v.to_array()).map(f32::to_bits)),
        tangents: section(&mut tangents.iter().flat_map(|v| v.to_array()).map(f32::to_bits)),
        vertex_colours: section(&mut colours.iter().flat_map(|v| v.to_array()).map(f32::to_bits)),
        uvs: [0, 1].map(|set| section(&mut uvs[set].iter().flat_map(|v| v.to_array()).map(f32::to_bits))),
        environment: section(&mut environment.into_iter().map(f32::to_bits)),
        profiles: section(&mut profiles.into_iter().map(f32::to_bits)),
    };
    (all, sections)
}
