//! Numbers of a scene and of its paths that all kernels read: one table, from which both the WGSL and the bytes are made.

use photosite_transport::integrator::PathLimits;
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::packed::PackedScene;

/// Number of the sampler of Sobol points.
pub(crate) const SAMPLER_SOBOL: u32 = 0;
/// Number of the sampler of independent numbers.
pub(crate) const SAMPLER_INDEPENDENT: u32 = 1;

/// Makes the table of names and values.
macro_rules! params {
    ($($name:ident: $kind:literal = $value:expr,)*) => {
        /// Names and WGSL types in their order; all take four bytes.
        pub(crate) const FIELDS: &[(&str, &str)] = &[$((stringify!($name), $kind)),*];

        /// Values in the same order.
        pub(crate) fn values(scene: &PackedScene, limits: PathLimits, sampler: SamplerKind, capacity: u32) -> Vec<u32> {
            let row = Row { scene, limits, sampler, capacity };
            let mut values = vec![$({
                let of: fn(&Row<'_>) -> u32 = $value;
                of(&row)
            }),*];
            values.resize(values.len() + PADDING, 0);
            values
        }
    };
}

/// Numbers behind the others that mean nothing: sizes of uniform blocks are whole numbers of 16 bytes.
pub(crate) const PADDING: usize = FIELDS.len().next_multiple_of(4) - FIELDS.len();

struct Row<'a> {
    scene: &'a PackedScene,
    limits: PathLimits,
    sampler: SamplerKind,
    capacity: u32,
}

params! {
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
