//! Refusals by name of parts of a capture that a card cannot do: a scene that is rendered is rendered as on the processor.
//!
//! The table of models is a `match` without a rest: a new one does not compile until it has its row here. Lights, environments and
//! shapes are all packed, as their own tables in `photosite-transport` do not compile otherwise.

use photosite_core::Invalid;
use photosite_transport::bsdf::Model;
use photosite_transport::integrator::RenderSettings;
use photosite_transport::scene::description::{AlphaMode, MaterialDescription, MaterialModel, SceneDescription};

/// First thing that keeps a scene and its settings from a card, with the key or the name of what asks for it; `None` where
/// a card renders all of it.
pub fn unsupported(scene: &SceneDescription, settings: &RenderSettings) -> Option<Invalid> {
    let of_materials = || scene.materials.iter().find_map(of_material);
    of_settings(settings).or_else(of_materials)
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
        Model::Layered(_) => None,
        Model::Mix(mix) => mix.models.iter().find_map(of_model),
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};
    use photosite_core::spectrum::{Dispersion, Spectrum, library};
    use photosite_transport::light::{LightKind, PointLight};
    use photosite_transport::scene::description::{
        Colour, Conductor, Diffuse, EmissionDescription, InstanceDescription, LightDescription, MeshDescription, Mix,
        Roughness, ShapeDescription, TexturedColour, ThinDielectric,
    };

    use super::*;

    fn scene(model: MaterialModel) -> SceneDescription {
        SceneDescription { materials: vec![MaterialDescription::new("thing", model)], ..Default::default() }
    }

    fn grey() -> MaterialModel {
        Model::Diffuse(Diffuse { reflectance: TexturedColour::plain(Colour::Rgb([0.5; 3])) })
    }

    fn white() -> EmissionDescription {
        EmissionDescription { colour: Colour::Rgb([1.0; 3]), level: Some(1.0), texture: None }
    }

    fn lamp() -> LightDescription {
        LightDescription {
            name: "lamp".into(),
            to_world: DAffine3::IDENTITY,
            later: vec![],
            kind: LightKind::Point(PointLight),
            emission: white(),
        }
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
        let mixed = Mix { models: [grey(), compensated.clone()], weight: 0.5 };
        for (model, named) in
            [(compensated, "energy_compensation"), (Model::Mix(Box::new(mixed)), "energy_compensation")]
        {
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
    fn what_moves_or_changes_its_shape_is_not_refused() {
        let mut moving = scene(grey());
        let later_shapes = vec![ShapeDescription::default()];
        moving.meshes.push(MeshDescription { later_shapes, ..MeshDescription::default() }.into());
        let object = InstanceDescription::of_mesh("cart", 0, DAffine3::IDENTITY);
        let later = vec![DAffine3::from_translation(DVec3::X)];
        moving.instances.push(InstanceDescription { later, ..object });
        moving.materials[0].emission = Some(white());
        moving.lights.push(LightDescription { later: vec![DAffine3::from_translation(DVec3::X)], ..lamp() });
        assert_eq!(words(&moving, &RenderSettings::default()), "");
    }

    #[test]
    fn lamps_are_rendered_behind_panes() {
        let (index, transmittance) = (Dispersion::constant(1.5), Spectrum::constant(1.0));
        let mut pane = scene(Model::ThinDielectric(ThinDielectric { index, transmittance }));
        pane.lights.push(lamp());
        assert_eq!(words(&pane, &RenderSettings::default()), "");
    }
}
