//! Numbers of a scene and of its paths that all kernels read.

use photosite_transport::integrator::PathLimits;
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::packed::PackedScene;

use crate::uniform::uniform_block;

/// Number of the sampler of Sobol points.
pub(crate) const SAMPLER_SOBOL: u32 = 0;
/// Number of the sampler of independent numbers.
pub(crate) const SAMPLER_INDEPENDENT: u32 = 1;

/// A scene, and the paths that are traced through it.
pub(crate) struct Row<'a> {
    pub(crate) scene: &'a PackedScene,
    pub(crate) limits: PathLimits,
    pub(crate) sampler: SamplerKind,
    pub(crate) capacity: u32,
}

uniform_block! {
    Row<'_>:
    capacity: "u32" = |r| r.capacity,
    max_depth: "u32" = |r| r.limits.max_depth,
    roulette_depth: "u32" = |r| r.limits.roulette_depth,
    sampler_kind: "u32" = |r| match r.sampler {
        SamplerKind::Sobol => SAMPLER_SOBOL,
        SamplerKind::Independent => SAMPLER_INDEPENDENT,
    },
    root: "u32" = |r| r.scene.root,
    instances: "u32" = |r| r.scene.sections.instances,
    quadrics: "u32" = |r| r.scene.sections.quadrics,
    meshes: "u32" = |r| r.scene.sections.meshes,
    materials: "u32" = |r| r.scene.sections.materials,
    textures: "u32" = |r| r.scene.sections.textures,
    lights: "u32" = |r| r.scene.sections.lights,
    tree: "u32" = |r| r.scene.sections.tree,
    distant: "u32" = |r| r.scene.sections.distant,
    sky: "u32" = |r| r.scene.sections.sky,
    colours: "u32" = |r| r.scene.sections.colours,
    layers: "u32" = |r| r.scene.sections.layers,
    corners: "u32" = |r| r.scene.attribute_sections.corners,
    normals: "u32" = |r| r.scene.attribute_sections.normals,
    tangents: "u32" = |r| r.scene.attribute_sections.tangents,
    vertex_colours: "u32" = |r| r.scene.attribute_sections.vertex_colours,
    uvs_of_first: "u32" = |r| r.scene.attribute_sections.uvs[0],
    uvs_of_second: "u32" = |r| r.scene.attribute_sections.uvs[1],
    environment_sums: "u32" = |r| r.scene.attribute_sections.environment,
    albedo_facets: "u32" = |r| r.scene.attribute_sections.albedos.facets[0],
    albedo_grooved_facets: "u32" = |r| r.scene.attribute_sections.albedos.facets[1],
    albedo_film: "u32" = |r| r.scene.attribute_sections.albedos.film,
    albedo_under_coat: "u32" = |r| r.scene.attribute_sections.albedos.hidden[0],
    albedo_under_sheen: "u32" = |r| r.scene.attribute_sections.albedos.hidden[1],
    albedo_sheen: "u32" = |r| r.scene.attribute_sections.albedos.sheen,
    albedo_glass: "u32" = |r| r.scene.attribute_sections.albedos.glass[0],
    albedo_grooved_glass: "u32" = |r| r.scene.attribute_sections.albedos.glass[1],
    albedo_film_glass: "u32" = |r| r.scene.attribute_sections.albedos.film_glass,
    profiles: "u32" = |r| r.scene.attribute_sections.profiles,
    tree_nodes: "u32" = |r| r.scene.lights.tree_nodes,
    distant_count: "u32" = |r| r.scene.lights.distant,
    irradiance: "f32" = |r| r.scene.lights.irradiance.to_bits(),
    environment: "u32" = |r| r.scene.lights.environment,
    environment_number: "u32" = |r| r.scene.lights.environment_number,
    environment_spectrum: "u32" = |r| r.scene.lights.environment_radiance,
    environment_texture: "u32" = |r| r.scene.lights.environment_texture,
    environment_columns: "u32" = |r| r.scene.lights.environment_cells[0],
    environment_rows: "u32" = |r| r.scene.lights.environment_cells[1],
    environment_cos: "f32" = |r| r.scene.lights.environment_rotation[0].to_bits(),
    environment_sin: "f32" = |r| r.scene.lights.environment_rotation[1].to_bits(),
    has_holes: "u32" = |r| u32::from(r.scene.has_holes),
    motions: "u32" = |r| r.scene.sections.motions,
}
