//! Materials that are kept, `[materials.NAME]` without a type: colour, roughness and metalness of the geometry's own
//! change.

use super::super::tables::KeptTable;
use super::super::tables::spectra::{Finder, unit};
use photosite_core::Invalid;
use photosite_transport::scene::description::{MaterialModel, TexturedColour, TexturedFactor};

/// Changes to the geometry's own material.
#[derive(Clone, Default)]
pub(crate) struct Changes {
    base_colour: Option<TexturedColour>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    energy_compensation: Option<bool>,
}

impl Changes {
    /// Changes that a table states.
    pub(crate) fn of(table: &KeptTable, finder: &mut Finder<'_>) -> Result<Self, Invalid> {
        let base_colour = table.base_colour.as_ref().map(|source| finder.reflectance(source)).transpose();
        Ok(Self {
            base_colour: base_colour.map_err(|invalid| invalid.within("base_colour"))?,
            roughness: table.roughness.map(|value| unit("roughness", value)).transpose()?,
            metallic: table.metallic.map(|value| unit("metallic", value)).transpose()?,
            energy_compensation: table.energy_compensation,
        })
    }

    /// Changes a material. Values of the table take the place of textures, too.
    pub(crate) fn apply(self, model: &mut MaterialModel) -> Result<(), Invalid> {
        let Self { base_colour, roughness, metallic, energy_compensation } = self;
        let places = Places::of(model);
        put("base_colour", base_colour, places.base_colour, |place, colour| *place = colour)?;
        put("roughness", roughness, places.roughness, Factor::set)?;
        put("metallic", metallic, places.metallic, Factor::set)?;
        put("energy_compensation", energy_compensation, places.energy_compensation, |place, is_on| *place = is_on)
    }
}

/// Puts the value of a key into its place, or refuses a key for which there is none.
fn put<V, P>(key: &str, value: Option<V>, place: Option<P>, set: impl FnOnce(P, V)) -> Result<(), Invalid> {
    match (value, place) {
        (None, _) => Ok(()),
        (Some(value), Some(place)) => {
            set(place, value);
            Ok(())
        }
        (Some(_), None) => {
            let message = "is not a key of this material as the geometry describes it";
            let help = "describe it again, for example with type = \"metallic-roughness\"";
            Err(Invalid::new(key, message).help(help))
        }
    }
}

/// Places of the values that a material has of those that may change.
#[derive(Default)]
struct Places<'a> {
    base_colour: Option<&'a mut TexturedColour>,
    roughness: Option<Factor<'a>>,
    metallic: Option<Factor<'a>>,
    energy_compensation: Option<&'a mut bool>,
}

/// Place of a factor, which may have a texture.
enum Factor<'a> {
    Plain(&'a mut f32),
    Textured(&'a mut TexturedFactor),
}

impl Factor<'_> {
    fn set(self, value: f32) {
        match self {
            Self::Plain(place) => *place = value,
            Self::Textured(place) => *place = TexturedFactor::plain(value),
        }
    }
}

impl<'a> Places<'a> {
    fn of(model: &'a mut MaterialModel) -> Self {
        let mut places = Self::default();
        match model {
            MaterialModel::Diffuse(diffuse) => places.base_colour = Some(&mut diffuse.reflectance),
            MaterialModel::OrenNayar(rough) => {
                places.base_colour = Some(&mut rough.reflectance);
                places.roughness = Some(Factor::Plain(&mut rough.roughness));
            }
            MaterialModel::Layered(layered) => {
                places.base_colour = Some(&mut layered.base_colour);
                places.roughness = Some(Factor::Textured(&mut layered.roughness));
                places.metallic = Some(Factor::Textured(&mut layered.metallic));
            }
            MaterialModel::Conductor(metal) => {
                places.roughness = Some(Factor::Plain(&mut metal.distribution.value));
                places.energy_compensation = Some(&mut metal.energy_compensation);
            }
            MaterialModel::Dielectric(glass) => {
                places.roughness = Some(Factor::Plain(&mut glass.distribution.value));
                places.energy_compensation = Some(&mut glass.energy_compensation);
            }
            MaterialModel::Retroreflective(sheeting) => {
                places.roughness = Some(Factor::Plain(&mut sheeting.distribution.value));
            }
            MaterialModel::Phong(_)
            | MaterialModel::Translucent(_)
            | MaterialModel::ThinDielectric(_)
            | MaterialModel::Mix(_) => {}
        }
        places
    }
}
