//! Words that scattering models and the layers of glTF's material share.

use crate::geometry::{NONE, Word};
use crate::light::packed::colour;
use crate::scene::{ColourSource, NormalMap};
use photosite_core::spectrum::SpectrumId;

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
    /// Sheeting that sends light back.
    pub const RETROREFLECTIVE: u32 = 9;
}

/// Texture of a normal map and its scale.
pub(super) fn normal_map_word(map: Option<NormalMap>) -> Word {
    map.map_or([NONE, 0, 0, 0], |map| [map.texture, map.scale.to_bits(), 0, 0])
}

/// A spectrum in place of a colour.
pub(super) fn spectrum(id: SpectrumId) -> Word {
    [colour::SPECTRUM, id.number(), NONE, 0]
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
