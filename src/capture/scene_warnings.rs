//! What is said of a scene as a whole: light that it lacks, that its materials lose, or that no path finds.

use std::collections::BTreeSet;

use crate::scene::description::{MaterialDescription, MaterialModel, SceneDescription};
use crate::spectrum::dispersion::lines;

/// Warnings of a scene with all its materials and lights.
pub(super) fn of(scene: &SceneDescription) -> Vec<String> {
    let seen = scene.instances.iter().flat_map(|instance| &scene.meshes[instance.meshes.clone()]);
    let used: BTreeSet<usize> = seen.map(|mesh| mesh.material).collect();
    let materials: Vec<&MaterialDescription> = used.iter().map(|index| &scene.materials[*index]).collect();
    let mut warnings: BTreeSet<String> = materials.iter().filter_map(|material| loss(material)).collect();
    warnings.extend(caustics(scene, &materials));
    let mut warnings: Vec<String> = warnings.into_iter().collect();
    if !shines(scene) {
        warnings.push("nothing in the scene emits light, so the picture will be black".to_owned());
    }
    warnings
}

/// Warning of a material whose microfacets lose much of the light.
fn loss(material: &MaterialDescription) -> Option<String> {
    /// A seventh of a stop.
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

/// Warning of solid glass before lamps that no refracted ray meets.
fn caustics(scene: &SceneDescription, materials: &[&MaterialDescription]) -> Option<String> {
    let glass: BTreeSet<&str> =
        materials.iter().filter(|m| is_solid_glass(&m.model)).map(|m| m.name.as_str()).collect();
    let (first, lamp) = (glass.first()?, &scene.lights.first()?.name);
    let others = match glass.len() - 1 {
        0 => String::new(),
        n => format!(" (as {n} more of glass)"),
    };
    Some(format!(
        "caustics of lamps without a surface are not found: the solid glass of the material {first:?}{others} throws a \
         black shadow in the light of {lamp:?}; put a small mesh with an emission in place of the lamp, or make a pane of \
         the glass (type = \"thin-dielectric\")"
    ))
}

/// Whether light is refracted into a body, all of it in one direction.
fn is_solid_glass(model: &MaterialModel) -> bool {
    match model {
        MaterialModel::Dielectric(glass) => {
            let is_one = glass.index.is_constant() && glass.index.index(lines::D) == 1.0;
            glass.distribution.distribution().is_smooth() && !is_one
        }
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
