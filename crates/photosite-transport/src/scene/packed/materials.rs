//! Materials as plain data.

use super::layers::{PackedLayers, flag};
pub use super::words::model;
use super::words::{MODEL_WORDS, colour_words, normal_map_word, spectrum};
use crate::bsdf::{
    Conductor, Dielectric, Diffuse, Ggx, Mix, Model, OrenNayar, Phong, RelativeIndex, Retroreflective, ThinDielectric,
    Translucent,
};
use crate::geometry::{NONE, Word};
use crate::light::packed::emission_words;
use crate::scene::{Alpha, Material, ScatteringModel, Scene, Tabled};
use photosite_core::spectrum::SpectrumId;

/// Words of a material: model and roughness; two parameters with the factor of each; two factors that textures scale; its
/// alpha; what it emits; its normal map, and the spectrum of what absorbs behind it.
pub const MATERIAL_WORDS: usize = MODEL_WORDS + 4;

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
    pub(super) fn packed_materials(&self) -> (Vec<Word>, PackedLayers) {
        let mut layers = PackedLayers::default();
        let mut words: Vec<Word> = Vec::new();
        // Models of mixes come behind all materials, whose numbers stay what they are.
        let mut more: Vec<&ScatteringModel> = Vec::new();
        let first = self.materials.len();
        for material in &self.materials {
            let Material { model, normal_map, emission, alpha, absorption } = material;
            words.extend(self.model_words(model, first, &mut more, &mut layers));
            words.push(alpha_word(alpha));
            words.extend(emission_words(emission.as_ref()));
            let [map, scale, ..] = normal_map_word(*normal_map);
            words.push([map, scale, absorption.map_or(NONE, SpectrumId::number), 0]);
        }
        let mut next = 0;
        while let Some(&model) = more.get(next) {
            let own = self.model_words(model, first, &mut more, &mut layers);
            words.extend(own);
            words.push(alpha_word(&Alpha::Opaque));
            words.extend(emission_words(None));
            words.push([NONE, 0, NONE, 0]);
            next += 1;
        }
        (words, layers)
    }

    /// A model with its parameters. Those that a mix is made of are numbered from `first` on.
    fn model_words<'a>(
        &'a self,
        model: &'a ScatteringModel,
        first: usize,
        more: &mut Vec<&'a ScatteringModel>,
        layers: &mut PackedLayers,
    ) -> [Word; MODEL_WORDS] {
        let none = [0; 4];
        let number = |x: f32| [x.to_bits(), 0, 0, 0];
        let [head, first_source, first_factor, second_source, second_factor] = match model {
            Model::Diffuse(Diffuse { reflectance }) => {
                let [source, factor] = colour_words(reflectance);
                [head(model::DIFFUSE), source, factor, none, none]
            }
            Model::Conductor(Conductor { eta, k, distribution, energy_compensation }) => {
                let bounces = layers.add_bounces(*energy_compensation, distribution, flag::METAL_BOUNCES);
                [rough_head(model::CONDUCTOR, distribution, bounces), spectrum(*eta), none, spectrum(*k), none]
            }
            Model::Dielectric(Dielectric { index, distribution, energy_compensation }) => {
                let bounces = layers.add_bounces(*energy_compensation, distribution, flag::GLASS_BOUNCES);
                [rough_head(model::DIELECTRIC, distribution, bounces), index_word(index), none, none, none]
            }
            Model::OrenNayar(OrenNayar { reflectance, roughness }) => {
                let [source, factor] = colour_words(reflectance);
                [head(model::OREN_NAYAR), source, factor, number(*roughness), none]
            }
            Model::Phong(Phong::<Tabled> { diffuse, specular, exponent }) => {
                let ([a, b], [c, d]) = (colour_words(diffuse), colour_words(specular));
                let [number, ..] = head(model::PHONG);
                [[number, exponent.to_bits(), 0, 0], a, b, c, d]
            }
            Model::Translucent(Translucent { reflectance, transmittance }) => {
                let ([a, b], [c, d]) = (colour_words(reflectance), colour_words(transmittance));
                [head(model::TRANSLUCENT), a, b, c, d]
            }
            Model::ThinDielectric(ThinDielectric { index, transmittance }) => {
                [head(model::THIN_DIELECTRIC), index_word(index), none, spectrum(*transmittance), none]
            }
            Model::Retroreflective(Retroreflective::<Tabled> {
                retroreflectance,
                reflectance,
                corners,
                distribution,
            }) => {
                let ([a, b], [c, d]) = (colour_words(retroreflectance), colour_words(reflectance));
                let corners = corners.numbers().map(f32::to_bits);
                let head = rough_head(model::RETROREFLECTIVE, distribution, false);
                return [head, a, b, c, d, [corners[0], corners[1], 0, 0], none];
            }
            Model::Layered(layered) => return layers.add(&self.layered[*layered as usize]),
            Model::Mix(mix) => {
                let Mix { models, weight } = &self.mixes[*mix as usize];
                let [a, b] = models.each_ref().map(|model| {
                    more.push(model);
                    (first + more.len() - 1) as u32
                });
                [head(model::MIX), [a, b, weight.to_bits(), 0], none, none, none]
            }
        };
        [head, first_source, first_factor, second_source, second_factor, none, none]
    }
}

/// Number of a model without microfacets.
fn head(model: u32) -> Word {
    [model, 0, 0, 0]
}

/// Number of a model, with the roughness of its microfacets and whether light bounces between them more than once.
fn rough_head(model: u32, distribution: &Ggx, bounces: bool) -> Word {
    let [x, y] = distribution.alpha().map(f32::to_bits);
    [model, x, y, u32::from(bounces)]
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

fn index_word(index: &RelativeIndex<SpectrumId>) -> Word {
    [index.eta.number(), u32::from(index.dispersive), u32::from(index.is_one), 0]
}
