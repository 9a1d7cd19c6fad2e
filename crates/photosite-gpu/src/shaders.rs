//! The kernels as one text: numbers that Rust and WGSL share, then a file for each concept.

use std::fmt::Write;

use photosite_core::spectrum::{LAMBDA_MIN_NM, TABLE_LEN};
use photosite_transport::bsdf::microfacet::SMALLEST_ALPHA;
use photosite_transport::integrator::PIECES;
use photosite_transport::optics::NODES_ALONG;
use photosite_transport::scene::packed::layers::flag;
use photosite_transport::scene::packed::lights::colour;
use photosite_transport::scene::packed::materials::{self, alpha, model};
use photosite_transport::scene::packed::{self, albedos, hierarchy, layers, lights};

use crate::params::{SAMPLER_INDEPENDENT, SAMPLER_SOBOL};
use crate::uniform::wgsl;
use crate::{film, params};

/// Threads of a workgroup.
pub const WORKGROUP_SIZE: u32 = 64;
/// Words of the state of a path.
pub const STATE_WORDS: u32 = 14;
/// Words of the start of a path.
pub const START_WORDS: u32 = 4;

/// Files in the order of what they need.
const FILES: [&str; 36] = [
    include_str!("wgsl/hash.wgsl"),
    include_str!("wgsl/sampler.wgsl"),
    include_str!("wgsl/math.wgsl"),
    include_str!("wgsl/spectrum.wgsl"),
    include_str!("wgsl/texture.wgsl"),
    include_str!("wgsl/quadric.wgsl"),
    include_str!("wgsl/triangle.wgsl"),
    include_str!("wgsl/holes.wgsl"),
    include_str!("wgsl/motion.wgsl"),
    include_str!("wgsl/deformation.wgsl"),
    include_str!("wgsl/traversal.wgsl"),
    include_str!("wgsl/surface.wgsl"),
    include_str!("wgsl/bsdf/model.wgsl"),
    include_str!("wgsl/bsdf/fresnel.wgsl"),
    include_str!("wgsl/bsdf/microfacet.wgsl"),
    include_str!("wgsl/bsdf/albedo.wgsl"),
    include_str!("wgsl/bsdf/compensation.wgsl"),
    include_str!("wgsl/bsdf/diffuse.wgsl"),
    include_str!("wgsl/bsdf/conductor.wgsl"),
    include_str!("wgsl/bsdf/dielectric.wgsl"),
    include_str!("wgsl/bsdf/oren_nayar.wgsl"),
    include_str!("wgsl/bsdf/phong.wgsl"),
    include_str!("wgsl/bsdf/retroreflective.wgsl"),
    include_str!("wgsl/bsdf/translucent.wgsl"),
    include_str!("wgsl/bsdf/thin_dielectric.wgsl"),
    include_str!("wgsl/bsdf/sheen.wgsl"),
    include_str!("wgsl/bsdf/layered/layers.wgsl"),
    include_str!("wgsl/bsdf/layered/thin_film.wgsl"),
    include_str!("wgsl/bsdf/layered/reflectance.wgsl"),
    include_str!("wgsl/bsdf/layered/energy_split.wgsl"),
    include_str!("wgsl/bsdf/layered/scatter.wgsl"),
    include_str!("wgsl/bsdf/dispatch.wgsl"),
    include_str!("wgsl/shading.wgsl"),
    include_str!("wgsl/layered_shading.wgsl"),
    include_str!("wgsl/medium.wgsl"),
    LIGHTS,
];

/// Files on lights.
const LIGHTS: &str = concat!(
    include_str!("wgsl/light_tree.wgsl"),
    include_str!("wgsl/distribution.wgsl"),
    include_str!("wgsl/sky.wgsl"),
    include_str!("wgsl/environment.wgsl"),
    include_str!("wgsl/emitter.wgsl"),
    include_str!("wgsl/light_sample.wgsl"),
    include_str!("wgsl/profile.wgsl"),
    include_str!("wgsl/projector.wgsl"),
    include_str!("wgsl/gaussian_beam.wgsl"),
    include_str!("wgsl/lights.wgsl"),
    include_str!("wgsl/panes.wgsl"),
);

/// Files on the film, behind those on paths.
const FILM: &str = concat!(
    include_str!("wgsl/film/film_tables.wgsl"),
    include_str!("wgsl/film/wavelengths.wgsl"),
    include_str!("wgsl/film/lens_table.wgsl"),
    include_str!("wgsl/film/camera.wgsl"),
    include_str!("wgsl/film/pixels.wgsl"),
);

/// Numbers that both sides share, by their names in WGSL.
const NUMBERS: &[(&str, u32)] = &[
    ("WORKGROUP_SIZE", WORKGROUP_SIZE),
    ("STATE_WORDS", STATE_WORDS),
    ("SAMPLER_SOBOL", SAMPLER_SOBOL),
    ("SAMPLER_INDEPENDENT", SAMPLER_INDEPENDENT),
    ("SPECTRUM_ENTRIES", TABLE_LEN as u32),
    ("DENSITY_PIECES", PIECES as u32),
    ("NODES_ALONG", NODES_ALONG as u32),
    ("NODE_WORDS", hierarchy::NODE_WORDS as u32),
    ("TRIANGLE_WORDS", hierarchy::TRIANGLE_WORDS as u32),
    ("QUADRIC_WORDS", hierarchy::QUADRIC_WORDS as u32),
    ("INSTANCE_WORDS", hierarchy::INSTANCE_WORDS as u32),
    ("KEY_WORDS", hierarchy::KEY_WORDS as u32),
    ("PLACE_WORLD", hierarchy::place::WORLD),
    ("PLACE_MOVING", hierarchy::place::MOVING),
    ("PLACE_DEFORMING", hierarchy::place::DEFORMING),
    ("LEAF", hierarchy::LEAF),
    ("LEAF_TRIANGLES", hierarchy::TRIANGLES),
    ("LEAF_QUADRIC", hierarchy::QUADRIC),
    ("LEAF_INSTANCES", hierarchy::INSTANCES),
    ("FIRST_BITS", hierarchy::FIRST_BITS),
    // Of two instances in a leaf one waits beside the nodes above it.
    ("STACK_SIZE", hierarchy::MAX_LEVELS as u32 + 2),
    ("MESH_WORDS", packed::MESH_WORDS as u32),
    ("MATERIAL_WORDS", materials::MATERIAL_WORDS as u32),
    ("TEXTURE_WORDS", packed::TEXTURE_WORDS as u32),
    ("TWO_SIDED", lights::TWO_SIDED),
    ("LIGHT_WORDS", lights::LIGHT_WORDS as u32),
    ("TREE_WORDS", lights::TREE_WORDS as u32),
    ("MODEL_DIFFUSE", model::DIFFUSE),
    ("MODEL_CONDUCTOR", model::CONDUCTOR),
    ("MODEL_DIELECTRIC", model::DIELECTRIC),
    ("MODEL_OREN_NAYAR", model::OREN_NAYAR),
    ("MODEL_PHONG", model::PHONG),
    ("MODEL_TRANSLUCENT", model::TRANSLUCENT),
    ("MODEL_THIN_DIELECTRIC", model::THIN_DIELECTRIC),
    ("MODEL_MIX", model::MIX),
    ("MODEL_LAYERED", model::LAYERED),
    ("MODEL_RETROREFLECTIVE", model::RETROREFLECTIVE),
    ("ALPHA_OPAQUE", alpha::OPAQUE),
    ("ALPHA_MASK", alpha::MASK),
    ("LAYER_WORDS", layers::LAYER_WORDS as u32),
    ("LAYERS_ANY", flag::ANY),
    ("LAYERS_TRANSMISSION", flag::TRANSMISSION),
    ("LAYERS_VOLUME", flag::VOLUME),
    ("LAYERS_DISPERSIVE", flag::DISPERSIVE),
    ("LAYERS_DIFFUSE_TRANSMISSION", flag::DIFFUSE_TRANSMISSION),
    ("LAYERS_GROOVES", flag::GROOVES),
    ("LAYERS_FILM", flag::FILM),
    ("LAYERS_SHEEN", flag::SHEEN),
    ("LAYERS_COAT", flag::COAT),
    ("PANES", flag::PANES),
    ("METAL_BOUNCES", flag::METAL_BOUNCES),
    ("GLASS_BOUNCES", flag::GLASS_BOUNCES),
    ("COLOUR_SPECTRUM", colour::SPECTRUM),
    ("COLOUR_TEXTURE", colour::TEXTURE),
    ("COLOUR_SPECTRUM_TEXTURE", colour::SPECTRUM_TEXTURE),
    ("LIGHT_TRIANGLE", lights::kind::TRIANGLE),
    ("LIGHT_QUADRIC", lights::kind::QUADRIC),
    ("LIGHT_POINT", lights::kind::POINT),
    ("LIGHT_SPOT", lights::kind::SPOT),
    ("LIGHT_DIRECTIONAL", lights::kind::DIRECTIONAL),
    ("LIGHT_ENVIRONMENT", lights::kind::ENVIRONMENT),
    ("LIGHT_DEFORMING", lights::kind::DEFORMING),
    ("LIGHT_PROFILE", lights::kind::PROFILE),
    ("LIGHT_PROJECTOR", lights::kind::PROJECTOR),
    ("LIGHT_GAUSSIAN_BEAM", lights::kind::GAUSSIAN_BEAM),
    ("ENVIRONMENT_CONSTANT", lights::environment::CONSTANT),
    ("ENVIRONMENT_IMAGE", lights::environment::IMAGE),
    ("ENVIRONMENT_SKY", lights::environment::SKY),
    ("SKY_KNOTS", lights::SKY_KNOTS as u32),
];

/// The tables of a scene, whose places are those of the layout in `tracer`.
const BINDINGS: &str = "\
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> nodes: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> tables: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> attributes: array<u32>;
@group(0) @binding(5) var<storage, read> spectra: array<vec2<f32>>;
@group(0) @binding(6) var<storage, read> texels: array<u32>;
";

/// Text of the functions, without the kernels of the wavefront, for scenes of these features ([`flag`]).
pub fn functions(features: u32) -> String {
    let mut text = String::new();
    let counts = albedos::NODE_COUNTS.map(|(name, count)| (name, count as u32));
    for (name, value) in NUMBERS.iter().chain(&counts).chain(&[("SCENE_FEATURES", features)]) {
        let _ = writeln!(text, "const {name} = {value}u;");
    }
    let [sky_first_nm, sky_step_nm] = lights::SKY_NM;
    let numbers = [
        ("LAMBDA_MIN_NM", LAMBDA_MIN_NM),
        ("SKY_FIRST_NM", sky_first_nm),
        ("SKY_STEP_NM", sky_step_nm),
        ("SMALLEST_ALPHA", SMALLEST_ALPHA),
    ];
    for (name, value) in numbers.into_iter().chain(albedos::TABLE_ENDS) {
        let _ = writeln!(text, "const {name} = {value:?}f;");
    }
    text += &wgsl("Params", params::FIELDS);
    text += BINDINGS;
    FILES.iter().for_each(|file| text += file);
    text
}

/// Text of all kernels of the wavefront, for scenes of these features.
pub fn wavefront(features: u32) -> String {
    functions(features) + include_str!("wgsl/path.wgsl") + &wgsl("Film", film::FIELDS) + FILM
}
