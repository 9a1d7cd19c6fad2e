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
            vec![$({
                let of: fn(&Row<'_>) -> u32 = $value;
                of(&row)
            }),*]
        }
    };
}

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
    albedos: "u32" = |r| r.scene.sections.albedos,
    corners: "u32" = |r| r.scene.attribute_sections.corners,
    normals: "u32" = |r| r.scene.attribute_sections.normals,
    tangents: "u32" = |r| r.scene.attribute_sections.tangents,
    vertex_colours: "u32" = |r| r.scene.attribute_sections.vertex_colours,
    uvs_of_first: "u32" = |r| r.scene.attribute_sections.uvs[0],
    uvs_of_second: "u32" = |r| r.scene.attribute_sections.uvs[1],
    environment_sums: "u32" = |r| r.scene.attribute_sections.environment,
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
}
