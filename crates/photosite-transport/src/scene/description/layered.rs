//! glTF's material as files describe it.

use super::texture::{TextureDescription, TexturedColour, TexturedFactor};
use photosite_core::spectrum::{Dispersion, Spectrum};

/// glTF 2.0's material with its `KHR_materials_*` extensions, from the base up. The default is what the specification
/// says of a material that says nothing, but for `metallic`, which is 0 here.
#[derive(Clone, Debug)]
pub struct LayeredDescription {
    /// Name of the model in the file that it comes from, for messages.
    pub kind: &'static str,
    /// Reflectance of the coloured base, F₀ of the metal, tint of transmission.
    pub base_colour: TexturedColour,
    /// Metalness 0–1.
    pub metallic: TexturedFactor,
    /// Perceptual roughness 0–1; α = roughness².
    pub roughness: TexturedFactor,
    /// Refractive index (`ior`, `dispersion`).
    pub index: Dispersion,
    /// Reflectance at normal incidence before the specular colour; left out, that of the index. glTF's index 0 means 1.
    pub normal_reflectance: Option<f32>,
    /// Weight of the facets' reflection where there is no metal (`specular`).
    pub specular: TexturedFactor,
    /// Factor of the facets' reflectance at normal incidence; may exceed 1.
    pub specular_colour: TexturedColour,
    /// Part of the light let in that goes straight on or is refracted, 0–1 (`transmission`).
    pub transmission: TexturedFactor,
    /// The medium of the closed volume that the surface bounds (`volume`): absorption, m⁻¹. None: a thin sheet.
    pub absorption_per_m: Option<Spectrum>,
    /// Part of the other light let in that comes out behind, 0–1, and its colour (`diffuse_transmission`).
    pub diffuse_transmission: Option<(TexturedFactor, TexturedColour)>,
    /// Grooves (`anisotropy`).
    pub anisotropy: Option<AnisotropyDescription>,
    /// A thin film (`iridescence`).
    pub film: Option<FilmDescription>,
    /// Colour and roughness of fibres (`sheen`).
    pub sheen: Option<(TexturedColour, TexturedFactor)>,
    /// Clear coat, a varnish (`clearcoat`).
    pub coat: Option<CoatDescription>,
}

impl Default for LayeredDescription {
    fn default() -> Self {
        Self {
            kind: "glTF",
            base_colour: TexturedColour::white(),
            metallic: TexturedFactor::plain(0.0),
            roughness: TexturedFactor::plain(1.0),
            index: Dispersion::constant(1.5),
            normal_reflectance: None,
            specular: TexturedFactor::plain(1.0),
            specular_colour: TexturedColour::white(),
            transmission: TexturedFactor::plain(0.0),
            absorption_per_m: None,
            diffuse_transmission: None,
            anisotropy: None,
            film: None,
            sheen: None,
            coat: None,
        }
    }
}

/// Grooves: α along them is mix(roughness², 1, strength²), across them roughness² (`anisotropy`).
#[derive(Clone, Debug)]
pub struct AnisotropyDescription {
    /// Strength, 0–1.
    pub strength: f32,
    /// Angle of the rougher direction from the tangent towards the bitangent, rad.
    pub rotation_rad: f32,
    /// Linear texture: R, G the direction, B times the strength.
    pub texture: Option<TextureDescription>,
}

/// A thin film (`iridescence`).
#[derive(Clone, Debug)]
pub struct FilmDescription {
    /// Part of the surface that the film covers, 0–1.
    pub weight: TexturedFactor,
    /// Refractive index, at least 1.
    pub index: f32,
    /// Thickness where the texture is 0 and where it is 1 or there is none, nm.
    pub thickness_nm: [f32; 2],
    /// Texture whose green channel places the thickness between the two of `thickness_nm`.
    pub thickness_texture: Option<TextureDescription>,
}

/// Clear coat of index 1.5, a varnish (`clearcoat`).
#[derive(Clone, Debug)]
pub struct CoatDescription {
    /// Weight of the coat, 0–1.
    pub weight: TexturedFactor,
    /// Perceptual roughness 0–1.
    pub roughness: TexturedFactor,
    /// Normal map of the coat, and the scale of its x and y; without one the coat is smooth, whatever the base has.
    pub normal_map: Option<(TextureDescription, f32)>,
}

/// Collects all textures of the layers, by shared or by mutable reference.
macro_rules! layered_textures {
    ($name:ident, $textured:ident, $pair:ident $(, $mutable:tt)?) => {
        pub(super) fn $name(& $($mutable)? self) -> Vec<Option<& $($mutable)? TextureDescription>> {
            let Self {
                kind: _, base_colour, metallic, roughness, index: _, normal_reflectance: _, specular, specular_colour,
                transmission, absorption_per_m: _, diffuse_transmission, anisotropy, film, sheen, coat,
            } = self;
            let mut all = vec![base_colour.texture.$textured(), specular_colour.texture.$textured()];
            all.extend([metallic, roughness, specular, transmission].map($pair));
            if let Some((factor, colour)) = diffuse_transmission {
                all.extend([$pair(factor), colour.texture.$textured()]);
            }
            if let Some(anisotropy) = anisotropy {
                all.push(anisotropy.texture.$textured());
            }
            if let Some(FilmDescription { weight, thickness_texture, .. }) = film {
                all.extend([$pair(weight), thickness_texture.$textured()]);
            }
            if let Some((colour, roughness)) = sheen {
                all.extend([colour.texture.$textured(), $pair(roughness)]);
            }
            if let Some(CoatDescription { weight, roughness, normal_map }) = coat {
                all.extend([$pair(weight), $pair(roughness), normal_map.$textured().map(|(texture, _)| texture)]);
            }
            all
        }
    };
}

impl LayeredDescription {
    layered_textures!(textures, as_ref, texture_of);
    layered_textures!(textures_mut, as_mut, texture_of_mut, mut);
}

fn texture_of(factor: &TexturedFactor) -> Option<&TextureDescription> {
    factor.texture.as_ref().map(|(texture, _)| texture)
}

fn texture_of_mut(factor: &mut TexturedFactor) -> Option<&mut TextureDescription> {
    factor.texture.as_mut().map(|(texture, _)| texture)
}
