//! Colours and numbers that may vary over a surface.

use crate::texture::{SamplerSettings, UvTransform};
use photosite_core::spectrum::Spectrum;

/// A colour or spectrum that scales a texture or stands alone.
#[derive(Clone, Debug)]
pub enum Colour {
    /// Linear sRGB; upsampled to a spectrum by [`photosite_core::spectrum::upsampling`].
    Rgb([f32; 3]),
    /// A measured or computed spectrum.
    Spectrum(Spectrum),
}

/// Use of an image by a material.
#[derive(Clone, Debug)]
pub struct TextureDescription {
    /// Index of the image.
    pub image: usize,
    /// Index of the UV set.
    pub uv_set: usize,
    /// Filter and wrap modes.
    pub sampler: SamplerSettings,
    /// Transform of the UVs.
    pub transform: UvTransform,
}

/// A colour, times an sRGB-encoded texture.
#[derive(Clone, Debug)]
pub struct TexturedColour {
    /// Colour that multiplies the texture, 0–1.
    pub colour: Colour,
    /// Texture whose RGB multiplies the colour.
    pub texture: Option<TextureDescription>,
}

impl TexturedColour {
    /// Makes a colour without a texture.
    pub fn plain(colour: Colour) -> Self {
        Self { colour, texture: None }
    }

    /// Makes white, without a texture.
    pub fn white() -> Self {
        Self::plain(Colour::Rgb([1.0; 3]))
    }
}

/// Factor: a number, times a channel of a linear texture.
#[derive(Clone, Debug, Default)]
pub struct TexturedFactor {
    /// Number that multiplies the texture.
    pub value: f32,
    /// Texture and the channel of it that counts.
    pub texture: Option<(TextureDescription, Channel)>,
}

impl TexturedFactor {
    /// Makes a factor without a texture.
    pub fn plain(value: f32) -> Self {
        Self { value, texture: None }
    }
}

/// A channel of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "named by what they are")]
pub enum Channel {
    R,
    G,
    B,
    A,
}
