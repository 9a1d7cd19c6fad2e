//! glTF's material as plain data, and what its extensions add to it.

use super::words::{MODEL_WORDS, colour_words, model, normal_map_word};
use crate::bsdf::Ggx;
use crate::geometry::{NONE, Word};
use crate::light::packed::colour;
use crate::scene::{FactorSource, LayeredMaterial};

/// Words of what extensions add to a material: part that passes; index by wavelength and [`flag`]s; diffuse transmission, and
/// its colour with the factor; grooves; a film, and its thickness; the colour of sheen with its factor, and roughness; coat,
/// its roughness and its normal map.
pub const LAYER_WORDS: usize = 14;

/// Features of scenes: the layers that any of their materials has, panes, and light that bounces between facets.
pub mod flag {
    /// Any material of glTF.
    pub const ANY: u32 = 1;
    /// Light that goes straight on or is refracted.
    pub const TRANSMISSION: u32 = 2;
    /// Medium behind the surface.
    pub const VOLUME: u32 = 4;
    /// Index that depends on wavelength.
    pub const DISPERSIVE: u32 = 8;
    /// Diffuse transmission.
    pub const DIFFUSE_TRANSMISSION: u32 = 16;
    /// Grooves, which make roughness anisotropic.
    pub const GROOVES: u32 = 32;
    /// Thin film.
    pub const FILM: u32 = 64;
    /// Fibres.
    pub const SHEEN: u32 = 128;
    /// Clear coat.
    pub const COAT: u32 = 256;
    /// Surfaces that light from sources without a surface passes straight on.
    pub const PANES: u32 = 512;
    /// Light that bounces more than once between facets of metal.
    pub const METAL_BOUNCES: u32 = 1024;
    /// Light that bounces more than once between facets of glass.
    pub const GLASS_BOUNCES: u32 = 2048;
}

/// Words of what extensions add to the materials of a scene, and the features of its materials.
#[derive(Default)]
pub(super) struct PackedLayers {
    pub(super) words: Vec<Word>,
    pub(super) flags: u32,
}

impl PackedLayers {
    /// Adds a feature of facets on which light bounces more than once, and returns whether they are such.
    pub(super) fn add_bounces(&mut self, is_compensated: bool, distribution: &Ggx, feature: u32) -> bool {
        let [x, y] = distribution.alpha();
        let counts = is_compensated && !distribution.is_smooth();
        if counts {
            self.flags |= feature | if x == y { 0 } else { flag::GROOVES };
        }
        counts
    }

    /// Adds a material, and returns its model with the number of what its extensions add, [`NONE`] without any.
    pub(super) fn add(&mut self, m: &LayeredMaterial) -> [Word; MODEL_WORDS] {
        let own = flags(m);
        self.flags |= own | flag::ANY;
        let more = if own == 0 { NONE } else { (self.words.len() / LAYER_WORDS) as u32 };
        if own != 0 {
            self.words.extend(extension_words(m, own));
        }
        let [base, base_factor] = colour_words(&m.base_colour);
        let white = [colour::SPECTRUM, NONE, NONE, 0];
        let [specular, specular_factor] = m.specular_colour.as_ref().map_or([white, [0; 4]], colour_words);
        let [weight, texture, channel, _] = factor(m.specular, 0);
        [
            [model::LAYERED, (m.f0 * m.specular_scale).to_bits(), weight, texture],
            base,
            base_factor,
            specular,
            specular_factor,
            factor(m.metallic, channel),
            factor(m.roughness, more),
        ]
    }
}

/// Layers that extensions add to a material.
fn flags(m: &LayeredMaterial) -> u32 {
    let transmits = m.transmission.value > 0.0;
    [
        (transmits, flag::TRANSMISSION),
        (m.has_volume, flag::VOLUME),
        (transmits && m.has_volume && m.dispersive, flag::DISPERSIVE),
        (m.diffuse_transmission.is_some(), flag::DIFFUSE_TRANSMISSION),
        (m.anisotropy.is_some(), flag::GROOVES),
        (m.film.is_some(), flag::FILM),
        (m.sheen.is_some(), flag::SHEEN),
        (m.coat.is_some(), flag::COAT),
    ]
    .into_iter()
    .filter_map(|(is_set, flag)| is_set.then_some(flag))
    .sum()
}

fn extension_words(m: &LayeredMaterial, flags: u32) -> [Word; LAYER_WORDS] {
    let mut words = [[0; 4]; LAYER_WORDS];
    words[0] = factor(m.transmission, 0);
    words[1] = [m.eta.number(), flags, 0, 0];
    if let Some((part, tint)) = &m.diffuse_transmission {
        words[2] = factor(*part, 0);
        [words[3], words[4]] = colour_words(tint);
    }
    if let Some(grooves) = m.anisotropy {
        let [cos, sin] = grooves.rotation.map(f32::to_bits);
        words[5] = [grooves.strength.to_bits(), cos, sin, grooves.texture.unwrap_or(NONE)];
    }
    if let Some(film) = m.film {
        let [low, high] = film.thickness_nm.map(f32::to_bits);
        words[6] = factor(film.weight, film.index.to_bits());
        words[7] = [low, high, film.texture.unwrap_or(NONE), 0];
    }
    if let Some((tint, roughness)) = &m.sheen {
        [words[8], words[9]] = colour_words(tint);
        words[10] = factor(*roughness, 0);
    }
    if let Some(coat) = m.coat {
        words[11] = factor(coat.weight, 0);
        words[12] = factor(coat.roughness, 0);
        words[13] = normal_map_word(coat.normal_map);
    }
    words
}

/// Words of a number with its texture and channel, and of what stands beside.
fn factor(source: FactorSource, beside: u32) -> Word {
    let [texture, channel] = source.texture.map_or([NONE, 0], |(texture, channel)| [texture, channel as u32]);
    [source.value.to_bits(), texture, channel, beside]
}
