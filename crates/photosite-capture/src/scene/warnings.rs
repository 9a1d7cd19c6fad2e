//! Warnings about a scene as a whole: light that it lacks, that its materials lose, or that no path finds.

use std::collections::{BTreeMap, BTreeSet};

use photosite_core::spectrum::dispersion::lines;
use photosite_transport::scene::description::{
    AlphaMode, MaterialDescription, MaterialModel, MeshDescription, SceneDescription,
};

/// Warnings of a scene with all its materials and lights.
pub(crate) fn of(scene: &SceneDescription) -> Vec<String> {
    let seen = scene.instances.iter().flat_map(|instance| &scene.meshes[instance.meshes.clone()]);
    let used: BTreeSet<usize> = seen.map(|mesh| mesh.material).collect();
    let materials: Vec<&MaterialDescription> = used.iter().map(|index| &scene.materials[*index]).collect();
    let mut warnings: BTreeSet<String> = materials.iter().filter_map(|material| loss(material)).collect();
    warnings.extend(caustics(scene, &materials));
    warnings.extend(invisible(scene));
    let mut warnings: Vec<String> = warnings.into_iter().collect();
    if !shines(scene) {
        warnings.push("nothing in the scene emits light, so the image will be black".to_owned());
    }
    warnings
}

/// Warning of a material whose microfacets lose much of the light.
fn loss(material: &MaterialDescription) -> Option<String> {
    /// Loss of light that is worth a warning: a seventh of a stop.
    const NOTABLE: f32 = 0.1;
    let (name, lost) = (&material.name, material.model.lost_light());
    (lost >= NOTABLE).then(|| {
        format!(
            "the microfacets of the material {name:?} lose {:.0} % of the light, which bounces more than once between \
             them; energy_compensation = true in its table gives it back",
            100.0 * lost
        )
    })
}

/// Warning of each material that no ray meets, as it is on the meshes that have it.
fn invisible(scene: &SceneDescription) -> Vec<String> {
    let mut of_materials: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let is_hidden: Vec<bool> = scene.meshes.iter().map(|mesh| is_invisible(scene, mesh)).collect();
    for instance in &scene.instances {
        for mesh in instance.meshes.clone().filter(|mesh| is_hidden[*mesh]) {
            let material = &scene.materials[scene.meshes[mesh].material];
            of_materials.entry(&material.name).or_default().insert(&instance.name);
        }
    }
    let warning = |(material, objects): (&str, BTreeSet<&str>)| {
        let first = objects.first().copied().unwrap_or_default();
        let others = match objects.len().saturating_sub(1) {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        format!(
            "the material {material:?} is wholly transparent, so nothing is seen where {first:?}{others} has it; its \
             opacity is d or map_d in an MTL file, the alpha of the base colour in glTF and of vertices in PLY; put it \
             right there, or describe the material in [materials.{material:?}]"
        )
    };
    of_materials.into_iter().map(warning).collect()
}

/// Whether no ray meets the surface of a mesh, or none changes there.
fn is_invisible(scene: &SceneDescription, mesh: &MeshDescription) -> bool {
    let material = &scene.materials[mesh.material];
    let reaches = |alpha: f32| match material.alpha {
        AlphaMode::Opaque => true,
        AlphaMode::Mask { cutoff } => alpha >= cutoff,
        AlphaMode::Blend => alpha > 0.0,
    };
    // The largest alpha of the vertices, and of the image: what is beyond them is nowhere.
    let of_vertices =
        if mesh.colours.is_empty() { 1.0 } else { mesh.colours.iter().map(|colour| colour.w).fold(0.0, f32::max) };
    let most = material.alpha_factor * of_vertices;
    let is_there = match &material.alpha_texture {
        None => reaches(most),
        // Seldom is more than the first texels looked at.
        Some(texture) => {
            let image = &scene.images[texture.image];
            (0..image.texels.len()).any(|texel| reaches(most * image.linear_texel(texel)[3]))
        }
    };
    !is_there || material.emission.is_none() && is_nothing(&material.model)
}

/// Whether light passes a surface as if it were not there.
fn is_nothing(model: &MaterialModel) -> bool {
    match model {
        MaterialModel::Dielectric(glass) => glass.index.is_one(),
        MaterialModel::ThinDielectric(pane) => pane.index.is_one() && pane.transmittance.min() >= 1.0,
        MaterialModel::Mix(mix) => {
            let [first, second] = &mix.models;
            (mix.weight >= 1.0 || is_nothing(first)) && (mix.weight <= 0.0 || is_nothing(second))
        }
        MaterialModel::Diffuse(_)
        | MaterialModel::Conductor(_)
        | MaterialModel::OrenNayar(_)
        | MaterialModel::Phong(_)
        | MaterialModel::Layered(_)
        | MaterialModel::Translucent(_)
        | MaterialModel::Retroreflective(_) => false,
    }
}

/// Warning of solid glass before emitters that no refracted ray meets.
fn caustics(scene: &SceneDescription, materials: &[&MaterialDescription]) -> Option<String> {
    let glass: BTreeSet<&str> =
        materials.iter().filter(|m| is_solid_glass(&m.model)).map(|m| m.name.as_str()).collect();
    let (first, light) = (glass.first()?, &scene.lights.first()?.name);
    let others = match glass.len() - 1 {
        0 => String::new(),
        n => format!(" (as {n} more of glass)"),
    };
    Some(format!(
        "caustics of lights without a surface are not found: the solid glass of the material {first:?}{others} throws a \
         black shadow in the light of {light:?}; put a small mesh with an emission in place of the light, or make a pane of \
         the glass (type = \"thin-dielectric\")"
    ))
}

/// Whether light is refracted into a body, all of it in one direction.
fn is_solid_glass(model: &MaterialModel) -> bool {
    match model {
        MaterialModel::Dielectric(glass) => glass.distribution.distribution().is_smooth() && !glass.index.is_one(),
        MaterialModel::Layered(layers) => {
            let is_polished = layers.roughness.value == 0.0 || layers.roughness.texture.is_some();
            let refracts = layers.absorption_per_m.is_some() && layers.transmission.value > 0.0;
            refracts && is_polished && layers.index.index(lines::D) != 1.0
        }
        MaterialModel::Mix(mix) => mix.models.iter().any(is_solid_glass),
        MaterialModel::Diffuse(_)
        | MaterialModel::Conductor(_)
        | MaterialModel::OrenNayar(_)
        | MaterialModel::Phong(_)
        | MaterialModel::Translucent(_)
        | MaterialModel::ThinDielectric(_)
        | MaterialModel::Retroreflective(_) => false,
    }
}

/// Whether there is any light.
fn shines(scene: &SceneDescription) -> bool {
    let shining_mesh = scene.meshes.iter().any(|mesh| scene.materials[mesh.material].emission.is_some());
    scene.environment.is_some() || !scene.lights.is_empty() || shining_mesh
}
