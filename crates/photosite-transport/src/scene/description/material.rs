//! Materials as files describe them.

use super::lights::EmissionDescription;
use super::model::{ChangedTextures, MaterialModel, Textures};
use super::texture::TextureDescription;

/// Material: the scattering and emission of a surface.
#[derive(Clone, Debug)]
pub struct MaterialDescription {
    /// Name by which capture files override the material.
    pub name: String,
    /// Scattering model.
    pub model: MaterialModel,
    /// Tangent-space normal map and the scale of its x and y.
    pub normal_map: Option<(TextureDescription, f32)>,
    /// Emission, if any.
    pub emission: Option<EmissionDescription>,
    /// Alpha mode: the parts of the surface that are there.
    pub alpha: AlphaMode,
    /// Alpha of the material as a whole, 0–1, times the alpha channel of the base-colour texture.
    pub alpha_factor: f32,
    /// Texture whose alpha channel multiplies the alpha of the material.
    pub alpha_texture: Option<TextureDescription>,
    /// Whether the back scatters like the front. A single-sided opaque material is black and lightless from behind.
    pub double_sided: bool,
}

impl MaterialDescription {
    /// A material of that name and model that covers the whole surface, without bumps or light of its own.
    pub fn new(name: impl Into<String>, model: MaterialModel) -> Self {
        Self {
            name: name.into(),
            model,
            normal_map: None,
            emission: None,
            alpha: AlphaMode::Opaque,
            alpha_factor: 1.0,
            alpha_texture: None,
            double_sided: false,
        }
    }

    /// Textures that the material uses.
    pub fn textures(&self) -> Vec<TextureDescription> {
        let mut all = Textures::default();
        self.model.visit(&mut all);
        let normal = self.normal_map.as_ref().map(|(texture, _)| texture);
        let emission = self.emission.as_ref().and_then(|emission| emission.texture.as_ref());
        all.0.extend([normal, emission, self.alpha_texture.as_ref()].into_iter().flatten().cloned());
        all.0
    }

    /// Changes all textures that the material uses.
    pub fn change_textures(&mut self, change: &mut dyn FnMut(&mut TextureDescription)) {
        self.model = self.model.map(&mut ChangedTextures(change));
        let normal = self.normal_map.as_mut().map(|(texture, _)| texture);
        let emission = self.emission.as_mut().and_then(|emission| emission.texture.as_mut());
        [normal, emission, self.alpha_texture.as_mut()].into_iter().flatten().for_each(change);
    }
}

/// glTF alpha modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Opaque surface: alpha is ignored.
    Opaque,
    /// Surface that is there where alpha ≥ cutoff.
    Mask {
        /// The threshold.
        cutoff: f32,
    },
    /// Surface that is there with probability alpha.
    Blend,
}
