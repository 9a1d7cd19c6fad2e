//! Materials: metallic-roughness with its maps, emission, alpha.

use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{AlphaMode as GltfAlphaMode, Material, NormalTexture};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;

use super::texture::{TextureUse, Textures};
use crate::Invalid;
use crate::io::warnings::Warnings;
use crate::scene::description::{
    AlphaMode, Colour, EmissionDescription, MaterialDescription, MaterialModel, TextureDescription,
};

const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

/// Reads material number `index`.
pub(super) fn read_material(
    material: &Material,
    index: usize,
    textures: &mut Textures<'_>,
    warnings: &mut Warnings,
) -> Result<MaterialDescription, Invalid> {
    let key = format!("materials[{index}]");
    let pbr = &material.pbr_metallic_roughness;
    let pbr_key = format!("{key}.pbrMetallicRoughness");
    let mut factor = |value: f32, name: &str| unit(value, &format!("{pbr_key}.{name}"), warnings);
    let [r, g, b, a] = pbr.base_color_factor.0;
    let base = [factor(r, "baseColorFactor")?, factor(g, "baseColorFactor")?, factor(b, "baseColorFactor")?];
    let alpha_factor = factor(a, "baseColorFactor")?;
    let metallic = factor(pbr.metallic_factor.0, "metallicFactor")?;
    let roughness = factor(pbr.roughness_factor.0, "roughnessFactor")?;

    let mut texture = |info: &Option<Info>, key: String| match info {
        Some(info) => textures.describe(texture_use(info), &key).map(Some),
        None => Ok(None),
    };
    let base_colour_texture = texture(&pbr.base_color_texture, format!("{pbr_key}.baseColorTexture"))?;
    let metallic_roughness_texture =
        texture(&pbr.metallic_roughness_texture, format!("{pbr_key}.metallicRoughnessTexture"))?;
    let emissive_texture = texture(&material.emissive_texture, format!("{key}.emissiveTexture"))?;
    let normal_key = format!("{key}.normalTexture");
    let normal_map = material.normal_texture.as_ref().map(|n| read_normal_map(n, &normal_key, textures)).transpose()?;

    let alpha = match material.alpha_mode {
        Checked::Valid(GltfAlphaMode::Opaque) => AlphaMode::Opaque,
        Checked::Valid(GltfAlphaMode::Mask) => AlphaMode::Mask {
            cutoff: finite(material.alpha_cutoff.unwrap_or_default().0, &format!("{key}.alphaCutoff"))?,
        },
        Checked::Valid(GltfAlphaMode::Blend) => AlphaMode::Blend,
        Checked::Invalid => {
            return Err(Invalid::new(format!("{key}.alphaMode"), "is unknown").help("write OPAQUE, MASK or BLEND"));
        }
    };
    let alpha_texture = if alpha == AlphaMode::Opaque { None } else { base_colour_texture.clone() };
    Ok(MaterialDescription {
        name: material.name.clone().unwrap_or_else(|| format!("material-{index}")),
        model: MaterialModel::MetallicRoughness {
            base_colour: Colour::Rgb(base),
            base_colour_texture,
            metallic,
            roughness,
            metallic_roughness_texture,
        },
        normal_map,
        emission: read_emission(material, &key, emissive_texture)?,
        alpha,
        alpha_factor,
        alpha_texture,
        double_sided: material.double_sided,
    })
}

/// What glTF gives meshes without a material: white, a metal of roughness 1.
pub(super) fn default_material() -> MaterialDescription {
    MaterialDescription {
        name: "default".to_owned(),
        model: MaterialModel::MetallicRoughness {
            base_colour: Colour::Rgb([1.0; 3]),
            base_colour_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
        },
        normal_map: None,
        emission: None,
        alpha: AlphaMode::Opaque,
        alpha_factor: 1.0,
        alpha_texture: None,
        double_sided: false,
    }
}

/// Emission in nit: the factor, times the strength of KHR_materials_emissive_strength.
fn read_emission(
    material: &Material,
    key: &str,
    texture: Option<TextureDescription>,
) -> Result<Option<EmissionDescription>, Invalid> {
    let factor = material.emissive_factor.0;
    let strength = material.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |s| s.emissive_strength.0);
    let not_negative = |value: f32, key: String| match finite(value, &key)? {
        value if value < 0.0 => Err(Invalid::new(key, format!("must not be negative, got {value}"))),
        value => Ok(value),
    };
    for value in factor {
        not_negative(value, format!("{key}.emissiveFactor"))?;
    }
    not_negative(strength, format!("{key}.extensions.KHR_materials_emissive_strength.emissiveStrength"))?;
    if strength == 0.0 || factor == [0.0; 3] {
        return Ok(None);
    }
    Ok(Some(EmissionDescription { colour: Colour::Rgb(factor), level: Some(f64::from(strength)), texture }))
}

fn read_normal_map(
    normal: &NormalTexture,
    key: &str,
    textures: &mut Textures<'_>,
) -> Result<(TextureDescription, f32), Invalid> {
    // The parser types this extension for all textures but this one.
    let transform: Option<TextureTransform> = normal
        .extensions
        .as_ref()
        .and_then(|e| e.others.get(TEXTURE_TRANSFORM))
        .map(|value| serde_json::from_value(value.clone()))
        .transpose()
        .map_err(|source| Invalid::new(format!("{key}.extensions.{TEXTURE_TRANSFORM}"), source.to_string()))?;
    let used = TextureUse { texture: normal.index.value(), uv_set: normal.tex_coord, transform: transform.as_ref() };
    Ok((textures.describe(used, key)?, finite(normal.scale, &format!("{key}.scale"))?))
}

fn texture_use(info: &Info) -> TextureUse<'_> {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
    TextureUse { texture: info.index.value(), uv_set: info.tex_coord, transform }
}

fn finite(value: f32, key: &str) -> Result<f32, Invalid> {
    if value.is_finite() { Ok(value) } else { Err(Invalid::new(key, format!("is not finite: {value}"))) }
}

/// A factor that should lie in 0–1. Some programs write a little more; that is cut off with a warning.
fn unit(value: f32, key: &str, warnings: &mut Warnings) -> Result<f32, Invalid> {
    let value = finite(value, key)?;
    if !(0.0..=1.0).contains(&value) {
        warnings.once(format!("{key} is {value}, outside 0–1, and is taken as {}", value.clamp(0.0, 1.0)));
    }
    Ok(value.clamp(0.0, 1.0))
}
