//! Refusals by name of parts of a capture that a card cannot do: a scene that is rendered is rendered as on the processor.
//!
//! The tables are `match`es without a rest: a new model, light or environment does not compile until it has its row here.

use photosite_core::Invalid;
use photosite_transport::bsdf::Model;
use photosite_transport::integrator::RenderSettings;
use photosite_transport::light::LightKind;
use photosite_transport::scene::description::{
    AlphaMode, EnvironmentDescription, InstanceDescription, LayeredDescription, LightDescription, MaterialDescription,
    MaterialModel, MeshDescription, SceneDescription,
};

/// First thing that keeps a scene and its settings from a card, with the key or the name of what asks for it; `None` where
/// a card renders all of it.
pub fn unsupported(scene: &SceneDescription, settings: &RenderSettings) -> Option<Invalid> {
    let of_materials = || scene.materials.iter().find_map(of_material);
    let of_lights = || scene.lights.iter().find_map(of_light);
    let of_meshes = || scene.meshes.iter().find_map(|mesh| of_mesh(mesh));
    let of_instances = || scene.instances.iter().find_map(of_instance);
    let of_environment = || scene.environment.as_ref().and_then(of_environment);
    of_settings(settings)
        .or_else(of_materials)
        .or_else(of_lights)
        .or_else(of_environment)
        .or_else(of_meshes)
        .or_else(of_instances)
}

fn refused(key: impl Into<String>, what: &str) -> Option<Invalid> {
    Some(
        Invalid::new(key, format!("{what} cannot be rendered on a graphics card yet")).help("render with --device cpu"),
    )
}

fn of_settings(settings: &RenderSettings) -> Option<Invalid> {
    if settings.splitting() > 1 {
        return refused("render.splitting", "paths that split");
    }
    if settings.light_paths() > 0.0 {
        return refused("render.light_paths", "paths from lights");
    }
    None
}

fn of_material(material: &MaterialDescription) -> Option<Invalid> {
    let MaterialDescription { name, model, normal_map: _, emission: _, alpha, .. } = material;
    let key = format!("materials.{name}");
    let of_alpha = match alpha {
        AlphaMode::Opaque | AlphaMode::Mask { .. } | AlphaMode::Blend => None,
    };
    of_alpha.or_else(|| of_model(model)).and_then(|what| refused(key, what))
}

/// Part of a scattering model that a card cannot do.
fn of_model(model: &MaterialModel) -> Option<&'static str> {
    match model {
        Model::Diffuse(_)
        | Model::OrenNayar(_)
        | Model::Phong(_)
        | Model::Translucent(_)
        | Model::ThinDielectric(_) => None,
        Model::Conductor(metal) => {
            let is_rough = !metal.distribution.distribution().is_smooth();
            (metal.energy_compensation && is_rough).then_some("energy_compensation of a rough metal")
        }
        Model::Dielectric(glass) => {
            let is_rough = !glass.distribution.distribution().is_smooth();
            (glass.energy_compensation && is_rough).then_some("energy_compensation of rough glass")
        }
        Model::Retroreflective(_) => Some("retroreflective sheeting"),
        Model::Layered(layers) => of_layers(layers),
        Model::Mix(mix) => mix.models.iter().find_map(of_model),
    }
}

/// Part of glTF's material that a card cannot do.
fn of_layers(layers: &LayeredDescription) -> Option<&'static str> {
    let transmits = layers.transmission.value > 0.0 || layers.absorption_per_m.is_some();
    let extensions = [
        (transmits, "transmission of glTF's material"),
        (layers.diffuse_transmission.is_some(), "diffuse transmission of glTF's material"),
        (layers.anisotropy.is_some(), "anisotropy of glTF's material"),
        (layers.film.is_some(), "iridescence of glTF's material"),
        (layers.sheen.is_some(), "sheen of glTF's material"),
        (layers.coat.is_some(), "the clear coat of glTF's material"),
    ];
    extensions.into_iter().find_map(|(is_set, what)| is_set.then_some(what))
}

fn of_light(light: &LightDescription) -> Option<Invalid> {
    let key = format!("lights ({})", light.name);
    if light.later.iter().any(|pose| *pose != light.to_world) {
        return refused(key, "a light that moves");
    }
    match light.kind {
        LightKind::Point(_)
        | LightKind::Spot(_)
        | LightKind::Directional(_)
        | LightKind::Profile(_)
        | LightKind::Projector(_)
        | LightKind::GaussianBeam(_) => None,
    }
}

fn of_environment(environment: &EnvironmentDescription) -> Option<Invalid> {
    match environment {
        EnvironmentDescription::Constant { .. }
        | EnvironmentDescription::Image { .. }
        | EnvironmentDescription::Sky(_) => None,
    }
}

fn of_mesh(mesh: &MeshDescription) -> Option<Invalid> {
    if mesh.later_shapes.is_empty() {
        None
    } else {
        refused(format!("mesh {}", mesh.name), "a mesh that changes its shape")
    }
}

fn of_instance(instance: &InstanceDescription) -> Option<Invalid> {
    let moves = instance.later.iter().any(|pose| *pose != instance.to_world);
    if moves { refused(format!("object {}", instance.name), "an object that moves") } else { None }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};
    use photosite_core::spectrum::{Dispersion, Spectrum, library};
    use photosite_transport::light::PointLight;
    use photosite_transport::scene::description::{
        Colour, Conductor, Diffuse, EmissionDescription, Mix, Roughness, TexturedColour, TexturedFactor, ThinDielectric,
    };

    use super::*;

    fn scene(model: MaterialModel) -> SceneDescription {
        SceneDescription { materials: vec![MaterialDescription::new("thing", model)], ..Default::default() }
    }

    fn grey() -> MaterialModel {
        Model::Diffuse(Diffuse { reflectance: TexturedColour::plain(Colour::Rgb([0.5; 3])) })
    }

    fn words(scene: &SceneDescription, settings: &RenderSettings) -> String {
        unsupported(scene, settings).map_or(String::new(), |invalid| invalid.to_string())
    }

    #[test]
    fn what_a_card_renders_is_not_refused() {
        assert_eq!(words(&scene(grey()), &RenderSettings::default()), "");
        assert_eq!(words(&scene(Model::Layered(Box::default())), &RenderSettings::default()), "");
    }

    #[test]
    fn what_a_card_cannot_render_is_named() {
        let silver = library::conductor("Ag").expect("a metal");
        let (eta, k, distribution) = (silver.eta, silver.k, Roughness::isotropic(0.5));
        let compensated = Model::Conductor(Conductor { eta, k, distribution, energy_compensation: true });
        let clear = LayeredDescription { transmission: TexturedFactor::plain(0.5), ..Default::default() };
        let mixed = Mix { models: [grey(), compensated.clone()], weight: 0.5 };
        for (model, named) in [
            (compensated, "energy_compensation"),
            (Model::Layered(Box::new(clear)), "transmission"),
            (Model::Mix(Box::new(mixed)), "energy_compensation"),
        ] {
            let words = words(&scene(model), &RenderSettings::default());
            assert!(words.starts_with("materials.thing: ") && words.contains(named), "{words}");
        }
    }

    #[test]
    fn strategies_that_a_card_does_not_have_are_named_by_their_keys() {
        for (settings, key) in [
            (RenderSettings { splitting: Some(4), ..Default::default() }, "render.splitting"),
            (RenderSettings { light_paths: Some(1.0), ..Default::default() }, "render.light_paths"),
        ] {
            assert!(words(&scene(grey()), &settings).starts_with(key));
        }
    }

    #[test]
    fn lamps_are_rendered_behind_panes_unless_they_move() {
        let (index, transmittance) = (Dispersion::constant(1.5), Spectrum::constant(1.0));
        let mut scene = scene(Model::ThinDielectric(ThinDielectric { index, transmittance }));
        scene.lights.push(LightDescription {
            name: "lamp".into(),
            to_world: DAffine3::IDENTITY,
            later: vec![],
            kind: LightKind::Point(PointLight),
            emission: EmissionDescription { colour: Colour::Rgb([1.0; 3]), level: Some(1.0), texture: None },
        });
        assert_eq!(words(&scene, &RenderSettings::default()), "");
        scene.lights[0].later.push(DAffine3::from_translation(DVec3::X));
        assert!(words(&scene, &RenderSettings::default()).starts_with("lights (lamp): a light that moves"));
    }
}
