//! `[materials.NAME]` without a type: the geometry's own material, of which colour, roughness and metalness change.

use super::colour::{Finder, unit};
use super::tables::KeptTable;
use crate::Invalid;
use crate::scene::description::{MaterialModel, TexturedColour, TexturedFactor};

/// What of the geometry's own material changes.
#[derive(Clone, Default)]
pub(super) struct Changes {
    base_colour: Option<TexturedColour>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    energy_compensation: Option<bool>,
}

impl Changes {
    /// Those of a table.
    pub(super) fn of(table: &KeptTable, finder: &mut Finder<'_>) -> Result<Self, Invalid> {
        let base_colour = table.base_colour.as_ref().map(|source| finder.reflectance(source)).transpose();
        Ok(Self {
            base_colour: base_colour.map_err(|invalid| invalid.within("base_colour"))?,
            roughness: table.roughness.map(|value| unit("roughness", value)).transpose()?,
            metallic: table.metallic.map(|value| unit("metallic", value)).transpose()?,
            energy_compensation: table.energy_compensation,
        })
    }

    /// Changes a material. What the table says takes the place of textures, too.
    pub(super) fn apply(self, model: &mut MaterialModel) -> Result<(), Invalid> {
        let Self { base_colour, roughness, metallic, energy_compensation } = self;
        for (key, is_done) in [
            ("base_colour", base_colour.is_none_or(|colour| set_base_colour(model, colour))),
            ("roughness", roughness.is_none_or(|value| set_roughness(model, value))),
            ("metallic", metallic.is_none_or(|value| set_metallic(model, value))),
            ("energy_compensation", energy_compensation.is_none_or(|value| set_energy_compensation(model, value))),
        ] {
            if !is_done {
                let message = "is not a key of this material as the geometry describes it";
                let help = "describe it again, for example with type = \"metallic-roughness\"";
                return Err(Invalid::new(key, message).help(help));
            }
        }
        Ok(())
    }
}

/// Whether the material has a base colour, which it has now.
fn set_base_colour(model: &mut MaterialModel, colour: TexturedColour) -> bool {
    let place = match model {
        MaterialModel::Diffuse(diffuse) => &mut diffuse.reflectance,
        MaterialModel::OrenNayar(rough) => &mut rough.reflectance,
        MaterialModel::Layered(layered) => &mut layered.base_colour,
        MaterialModel::Conductor(_)
        | MaterialModel::Dielectric(_)
        | MaterialModel::Phong(_)
        | MaterialModel::Translucent(_)
        | MaterialModel::ThinDielectric(_)
        | MaterialModel::Retroreflective(_)
        | MaterialModel::Mix(_) => return false,
    };
    *place = colour;
    true
}

fn set_roughness(model: &mut MaterialModel, value: f32) -> bool {
    match model {
        MaterialModel::Layered(layered) => layered.roughness = TexturedFactor::plain(value),
        MaterialModel::OrenNayar(rough) => rough.roughness = value,
        MaterialModel::Conductor(metal) => metal.distribution.value = value,
        MaterialModel::Dielectric(glass) => glass.distribution.value = value,
        MaterialModel::Retroreflective(sheeting) => sheeting.distribution.value = value,
        MaterialModel::Diffuse(_)
        | MaterialModel::Phong(_)
        | MaterialModel::Translucent(_)
        | MaterialModel::ThinDielectric(_)
        | MaterialModel::Mix(_) => return false,
    }
    true
}

fn set_metallic(model: &mut MaterialModel, value: f32) -> bool {
    match model {
        MaterialModel::Layered(layered) => layered.metallic = TexturedFactor::plain(value),
        MaterialModel::Diffuse(_)
        | MaterialModel::OrenNayar(_)
        | MaterialModel::Conductor(_)
        | MaterialModel::Dielectric(_)
        | MaterialModel::Phong(_)
        | MaterialModel::Translucent(_)
        | MaterialModel::ThinDielectric(_)
        | MaterialModel::Retroreflective(_)
        | MaterialModel::Mix(_) => return false,
    }
    true
}

fn set_energy_compensation(model: &mut MaterialModel, value: bool) -> bool {
    match model {
        MaterialModel::Conductor(metal) => metal.energy_compensation = value,
        MaterialModel::Dielectric(glass) => glass.energy_compensation = value,
        MaterialModel::Diffuse(_)
        | MaterialModel::OrenNayar(_)
        | MaterialModel::Layered(_)
        | MaterialModel::Phong(_)
        | MaterialModel::Translucent(_)
        | MaterialModel::ThinDielectric(_)
        | MaterialModel::Retroreflective(_)
        | MaterialModel::Mix(_) => return false,
    }
    true
}
