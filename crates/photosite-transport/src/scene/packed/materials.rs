//! Materials as plain data, with the table of the models that have a packed form.

use super::layers::PackedLayers;
use crate::bsdf::{
    Conductor, Dielectric, Diffuse, Ggx, Mix, Model, OrenNayar, Phong, RelativeIndex, ThinDielectric, Translucent,
};
use crate::geometry::{NONE, Word};
use crate::light::packed::{colour, emission_words};
use crate::scene::{Alpha, ColourSource, Material, NormalMap, ScatteringModel, Scene, Tabled};
use photosite_core::Invalid;
use photosite_core::spectrum::SpectrumId;

/// Words of a material: model and roughness; two parameters with the factor of each; two factors that textures scale; its
/// alpha; what it emits; its normal map, and the spectrum of what absorbs behind it.
pub const MATERIAL_WORDS: usize = MODEL_WORDS + 4;
/// Words of a model.
pub(super) const MODEL_WORDS: usize = 7;

/// Numbers of the models in packed materials.
pub mod model {
    /// Lambert's law.
    pub const DIFFUSE: u32 = 0;
    /// A metal.
    pub const CONDUCTOR: u32 = 1;
    /// A clear medium.
    pub const DIELECTRIC: u32 = 2;
    /// A diffuse surface with relief.
    pub const OREN_NAYAR: u32 = 3;
    /// Phong's model.
    pub const PHONG: u32 = 4;
    /// A thin diffuse sheet.
    pub const TRANSLUCENT: u32 = 5;
    /// A polished pane.
    pub const THIN_DIELECTRIC: u32 = 6;
    /// Mix of two materials.
    pub const MIX: u32 = 7;
    /// glTF's material.
    pub const LAYERED: u32 = 8;
}

/// Numbers of the modes of alpha.
pub mod alpha {
    /// A surface that is there everywhere.
    pub const OPAQUE: u32 = 0;
    /// A surface that is there where alpha reaches a threshold.
    pub const MASK: u32 = 1;
    /// A surface that is there with probability alpha.
    pub const BLEND: u32 = 2;
}

impl Scene {
    /// The materials, and behind them those that mixes are made of; and what glTF's extensions add to theirs.
    pub(super) fn packed_materials(&self) -> Result<(Vec<Word>, PackedLayers), Invalid> {
        let mut layers = PackedLayers::default();
        let mut words: Vec<Word> = Vec::new();
        // Models of mixes come behind all materials, whose numbers stay what they are.
        let mut more: Vec<&ScatteringModel> = Vec::new();
        let first = self.materials.len();
        for material in &self.materials {
            let Material { model, normal_map, emission, alpha, absorption } = material;
            words.extend(self.model_words(model, first, &mut more, &mut layers)?);
            words.push(alpha_word(alpha));
            words.extend(emission_words(emission.as_ref()));
            let [map, scale, ..] = normal_map_word(*normal_map);
            words.push([map, scale, absorption.map_or(NONE, SpectrumId::number), 0]);
        }
        let mut next = 0;
        while let Some(&model) = more.get(next) {
            let own = self.model_words(model, first, &mut more, &mut layers)?;
            words.extend(own);
            words.push(alpha_word(&Alpha::Opaque));
            words.extend(emission_words(None));
            words.push([NONE, 0, NONE, 0]);
            next += 1;
        }
        Ok((words, layers))
    }

    /// A model with its parameters. Those that a mix is made of are numbered from `first` on.
    fn model_words<'a>(
        &'a self,
        model: &'a ScatteringModel,
        first: usize,
        more: &mut Vec<&'a ScatteringModel>,
        layers: &mut PackedLayers,
    ) -> Result<[Word; MODEL_WORDS], Invalid> {
        let unknown = |what: &str| Err(Invalid::new("materials", format!("{what} not known to devices yet")));
        let none = [0; 4];
        let number = |x: f32| [x.to_bits(), 0, 0, 0];
        let [head, first_source, first_factor, second_source, second_factor] = match model {
            Model::Diffuse(Diffuse { reflectance }) => {
                let [source, factor] = colour_words(reflectance);
                [head(model::DIFFUSE, None), source, factor, none, none]
            }
            Model::Conductor(Conductor { eta, k, distribution, energy_compensation }) => {
                if *energy_compensation && !distribution.is_smooth() {
                    return unknown("energy_compensation of rough metals is");
                }
                [head(model::CONDUCTOR, Some(distribution)), spectrum(*eta), none, spectrum(*k), none]
            }
            Model::Dielectric(Dielectric { index, distribution, energy_compensation }) => {
                if *energy_compensation && !distribution.is_smooth() {
                    return unknown("energy_compensation of rough glass is");
                }
                [head(model::DIELECTRIC, Some(distribution)), index_word(index), none, none, none]
            }
            Model::OrenNayar(OrenNayar { reflectance, roughness }) => {
                let [source, factor] = colour_words(reflectance);
                [head(model::OREN_NAYAR, None), source, factor, number(*roughness), none]
            }
            Model::Phong(Phong::<Tabled> { diffuse, specular, exponent }) => {
                let ([a, b], [c, d]) = (colour_words(diffuse), colour_words(specular));
                let [number, ..] = head(model::PHONG, None);
                [[number, exponent.to_bits(), 0, 0], a, b, c, d]
            }
            Model::Translucent(Translucent { reflectance, transmittance }) => {
                let ([a, b], [c, d]) = (colour_words(reflectance), colour_words(transmittance));
                [head(model::TRANSLUCENT, None), a, b, c, d]
            }
            Model::ThinDielectric(ThinDielectric { index, transmittance }) => {
                [head(model::THIN_DIELECTRIC, None), index_word(index), none, spectrum(*transmittance), none]
            }
            Model::Retroreflective(_) => return unknown("retroreflective materials are"),
            Model::Layered(layered) => return Ok(layers.add(&self.layered[*layered as usize])),
            Model::Mix(mix) => {
                let Mix { models, weight } = &self.mixes[*mix as usize];
                let [a, b] = models.each_ref().map(|model| {
                    more.push(model);
                    (first + more.len() - 1) as u32
                });
                [head(model::MIX, None), [a, b, weight.to_bits(), 0], none, none, none]
            }
        };
        Ok([head, first_source, first_factor, second_source, second_factor, none, none])
    }
}

/// Number of a model, with the roughness of its microfacets.
fn head(model: u32, distribution: Option<&Ggx>) -> Word {
    let [x, y] = distribution.map_or([0.0; 2], Ggx::alpha);
    [model, x.to_bits(), y.to_bits(), 0]
}

/// Mode, factor, texture and threshold.
fn alpha_word(alpha: &Alpha) -> Word {
    let word = |mode: u32, factor: f32, texture: Option<u32>, cutoff: f32| {
        [mode, factor.to_bits(), texture.unwrap_or(NONE), cutoff.to_bits()]
    };
    match *alpha {
        Alpha::Opaque => word(alpha::OPAQUE, 1.0, None, 0.0),
        Alpha::Mask { factor, texture, cutoff } => word(alpha::MASK, factor, texture, cutoff),
        Alpha::Blend { factor, texture } => word(alpha::BLEND, factor, texture, 0.0),
    }
}

/// Texture of a normal map and its scale.
pub(super) fn normal_map_word(map: Option<NormalMap>) -> Word {
    map.map_or([NONE, 0, 0, 0], |map| [map.texture, map.scale.to_bits(), 0, 0])
}

fn spectrum(id: SpectrumId) -> Word {
    [colour::SPECTRUM, id.number(), NONE, 0]
}

fn index_word(index: &RelativeIndex<SpectrumId>) -> Word {
    [index.eta.number(), u32::from(index.dispersive), u32::from(index.is_one), 0]
}

/// Kind of a colour with its spectrum and texture, and its factor.
pub(super) fn colour_words(source: &ColourSource) -> [Word; 2] {
    match *source {
        ColourSource::Spectrum(id) => [spectrum(id), [0; 4]],
        ColourSource::Texture { factor: [r, g, b], texture } => {
            [[colour::TEXTURE, NONE, texture, 0], [r.to_bits(), g.to_bits(), b.to_bits(), 0]]
        }
        ColourSource::SpectrumTexture { spectrum, texture } => {
            [[colour::SPECTRUM_TEXTURE, spectrum.number(), texture, 0], [0; 4]]
        }
    }
}
