//! Textures as plain data: images one after the other, each once, and a record for each texture.

use super::{Bitmap, Filter, SamplerSettings, Texels, Texture, Wrap};
use crate::geometry::Word;

/// Words of a texture: texels, sides and form; transform of texture coordinates, and their set.
pub const TEXTURE_WORDS: usize = 3;

/// Textures as they are packed.
#[derive(Default)]
pub(crate) struct PackedTextures {
    /// Records, [`TEXTURE_WORDS`] each.
    pub(crate) words: Vec<Word>,
    /// Texels of all images: one number each of 8 bits a channel, two of 16, three of floats.
    pub(crate) texels: Vec<u32>,
    /// Images that are there, by their place in memory, and where their texels begin.
    images: Vec<(*const Bitmap, u32)>,
}

impl PackedTextures {
    /// Adds a texture; returns its number.
    pub(crate) fn add(&mut self, texture: &Texture) -> u32 {
        let image = texture.image();
        let known = self.images.iter().find(|(known, _)| std::ptr::eq(*known, image));
        let (first, form) = (known.map(|(_, first)| *first), form_of(&image.texels));
        let first = first.unwrap_or_else(|| {
            let first = self.texels.len() as u32;
            self.images.push((&raw const *image, first));
            extend(&mut self.texels, &image.texels);
            first
        });
        let SamplerSettings { wrap: [u, v], filter } = texture.sampler();
        let filter = match filter {
            Filter::Linear => 0,
            Filter::Nearest => 1,
        };
        let settings = form | filter << 2 | number_of(u) << 4 | number_of(v) << 6;
        let transform = texture.transform();
        let [a, b, c, d] = transform.matrix2.to_cols_array().map(f32::to_bits);
        let [x, y] = transform.translation.to_array().map(f32::to_bits);
        self.words.extend([
            [first, image.width as u32, image.height as u32, settings],
            [a, b, c, d],
            [x, y, texture.uv_set, 0],
        ]);
        (self.words.len() / TEXTURE_WORDS - 1) as u32
    }
}

fn form_of(texels: &Texels) -> u32 {
    match texels {
        Texels::Rgba8(_) => 0,
        Texels::Rgba16(_) => 1,
        Texels::Rgb32F(_) => 2,
    }
}

fn number_of(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 0,
        Wrap::MirroredRepeat => 1,
        Wrap::ClampToEdge => 2,
    }
}

fn extend(all: &mut Vec<u32>, texels: &Texels) {
    match texels {
        Texels::Rgba8(texels) => all.extend(texels.iter().map(|texel| u32::from_le_bytes(*texel))),
        Texels::Rgba16(texels) => all.extend(texels.iter().flat_map(|&[r, g, b, a]| {
            let pair = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
            [pair(r, g), pair(b, a)]
        })),
        Texels::Rgb32F(texels) => all.extend(texels.iter().flat_map(|texel| texel.map(f32::to_bits))),
    }
}
