//! What MTL materials mean physically. The format describes formulas of the early nineties; this is the reading:
//!
//! | the file says | it is taken as |
//! |---|---|
//! | `Pr`, `Pm`, `Pc`, `Ps`, `aniso` or a map of `Pr` or `Pm` | glTF's material with these and the colour `Kd` |
//! | `Ni` > 1 and (`illum` 4, 6, 7, 9 or `d` < 1), no `map_d` | clear glass of index `Ni`, tinted `Tf` where light passes its surface |
//! | `Kd` black, `Ks` not, `illum` 3, 5 or 8 | a mirroring metal of colour `Ks` |
//! | `Ks` not black and `Ns` > 0, `illum` not 0 or 1 | plastic of colour `Kd`: metallic-roughness, not metallic |
//! | otherwise | diffuse of colour `Kd` |
//!
//! `Ns` is the exponent n of a Blinn–Phong lobe, of which α = √(2/(n + 2)) is the microfacet roughness
//! ([Walter07](crate::references#walter07) §5.2), so the perceptual roughness is √α. `d` below 1 lets through a part of
//! the light (`Blend`) unless it is glass. Plastic and glTF's material have the index `Ni` where it is above 1, else 1.5.
//! `Pc` and `Pcr` are weight and roughness of a coat, `Ps` the weight of white sheen of roughness 0.5 (assumed: the format
//! has no key for it), `aniso` 0–1 and `anisor` (in turns) are strength and rotation of grooves; `-bm` scales the bumps of `norm`. `Ke` is in nit. Surfaces scatter on both sides, since the format has no
//! notion of a front.

use super::mtl::{Map, MtlMaterial};
use crate::io::warnings::Warnings;
use crate::scene::description::{
    AlphaMode, AnisotropyDescription, Channel, CoatDescription, Colour, EmissionDescription, LayeredDescription,
    MaterialDescription, MaterialModel, TextureDescription, TexturedColour, TexturedFactor,
};
use crate::spectrum::{Dispersion, Spectrum};

/// The textures of a material, its pictures already among the scene's.
#[derive(Debug, Default)]
pub(super) struct MaterialTextures {
    pub(super) diffuse: Option<TextureDescription>,
    pub(super) emission: Option<TextureDescription>,
    pub(super) opacity: Option<TextureDescription>,
    pub(super) roughness: Option<TextureDescription>,
    pub(super) metallic: Option<TextureDescription>,
    pub(super) normal: Option<TextureDescription>,
}

/// Perceptual roughness of sheen, of which the format says nothing.
const SHEEN_ROUGHNESS: f32 = 0.5;

/// Reflectance of surfaces of which nothing is known.
const DEFAULT_REFLECTANCE: f32 = 0.5;

/// A diffuse grey material, for faces whose material is not described.
pub(super) fn undescribed(name: &str) -> MaterialDescription {
    let reflectance = TexturedColour::plain(Colour::Rgb([DEFAULT_REFLECTANCE; 3]));
    MaterialDescription { double_sided: true, ..MaterialDescription::new(name, MaterialModel::Diffuse { reflectance }) }
}

/// The material that the module's table gives.
pub(super) fn describe(
    mtl: &MtlMaterial,
    mut textures: MaterialTextures,
    warnings: &mut Warnings,
) -> MaterialDescription {
    let diffuse = match (mtl.diffuse, &textures.diffuse) {
        (Some(colour), _) => reflectance(mtl, "Kd", colour, warnings),
        (None, Some(_)) => [1.0; 3],
        (None, None) => [DEFAULT_REFLECTANCE; 3],
    };
    let opacity = mtl.opacity.unwrap_or(1.0).clamp(0.0, 1.0);
    let is_glass = is_glass(mtl);
    let see_through = !is_glass && (opacity < 1.0 || textures.opacity.is_some());
    let bumps = mtl.normal_map.as_ref().map_or(1.0, |map| map.bumps);
    let model = if is_glass { glass(mtl) } else { opaque(mtl, diffuse, &mut textures, warnings) };
    MaterialDescription {
        name: mtl.name.clone(),
        model,
        normal_map: textures.normal.map(|texture| (texture, bumps)),
        emission: emission(mtl, textures.emission),
        alpha: if see_through { AlphaMode::Blend } else { AlphaMode::Opaque },
        alpha_factor: if see_through { opacity } else { 1.0 },
        alpha_texture: if see_through { textures.opacity } else { None },
        double_sided: true,
    }
}

fn is_glass(mtl: &MtlMaterial) -> bool {
    let refracts = matches!(mtl.illumination_model, Some(4 | 6 | 7 | 9)) || mtl.opacity.is_some_and(|d| d < 1.0);
    mtl.index.is_some_and(|index| index > 1.0) && refracts && mtl.opacity_map.is_none()
}

fn glass(mtl: &MtlMaterial) -> MaterialModel {
    let (index, roughness) = (index(mtl), mtl.roughness.unwrap_or(0.0).clamp(0.0, 1.0));
    match mtl.transmission_filter.map(|filter| filter.map(|c| c.clamp(0.0, 1.0))) {
        None | Some([1.0, 1.0, 1.0]) => MaterialModel::Dielectric { index, roughness },
        Some(filter) => MaterialModel::Layered(Box::new(LayeredDescription {
            base_colour: TexturedColour::plain(Colour::Rgb(filter)),
            roughness: TexturedFactor::plain(roughness),
            index,
            transmission: TexturedFactor::plain(1.0),
            absorption_per_m: Some(Spectrum::constant(0.0)),
            ..LayeredDescription::default()
        })),
    }
}

fn index(mtl: &MtlMaterial) -> Dispersion {
    Dispersion::constant(f64::from(mtl.index.filter(|n| n.is_finite() && *n > 1.0).unwrap_or(1.5)))
}

/// glTF's material with what the extension of the format for it says.
fn physically_based(mtl: &MtlMaterial, diffuse: [f32; 3], textures: &mut MaterialTextures) -> MaterialModel {
    let unit = |value: Option<f32>, default: f32| value.unwrap_or(default).clamp(0.0, 1.0);
    let channel = |map: &Option<Map>| map.as_ref().map_or(Channel::R, |map| map.channel);
    let factor = |value, texture: Option<TextureDescription>, map| TexturedFactor {
        value,
        texture: texture.map(|texture| (texture, channel(map))),
    };
    // A map without its number stands alone.
    let alone = |texture: &Option<TextureDescription>, otherwise| if texture.is_some() { 1.0 } else { otherwise };
    let by_exponent = mtl.shininess.map_or(0.5, roughness_of_exponent);
    let roughness = unit(mtl.roughness, alone(&textures.roughness, by_exponent));
    let metallic = unit(mtl.metallic, alone(&textures.metallic, 0.0));
    let (sheen, strength) = (unit(mtl.sheen, 0.0), unit(mtl.anisotropy, 0.0));
    MaterialModel::Layered(Box::new(LayeredDescription {
        base_colour: TexturedColour { colour: Colour::Rgb(diffuse), texture: textures.diffuse.take() },
        metallic: factor(metallic, textures.metallic.take(), &mtl.metallic_map),
        roughness: factor(roughness, textures.roughness.take(), &mtl.roughness_map),
        index: index(mtl),
        coat: mtl.coat.filter(|&weight| weight > 0.0).map(|weight| CoatDescription {
            weight: TexturedFactor::plain(weight.min(1.0)),
            roughness: TexturedFactor::plain(unit(mtl.coat_roughness, 0.0)),
            normal_map: None,
        }),
        sheen: (sheen > 0.0)
            .then(|| (TexturedColour::plain(Colour::Rgb([sheen; 3])), TexturedFactor::plain(SHEEN_ROUGHNESS))),
        anisotropy: (strength > 0.0).then(|| AnisotropyDescription {
            strength,
            rotation_rad: mtl.anisotropy_rotation.unwrap_or(0.0) * std::f32::consts::TAU,
            texture: None,
        }),
        ..LayeredDescription::default()
    }))
}

/// Whether a key of the extension for physically based materials is there.
fn is_physically_based(mtl: &MtlMaterial) -> bool {
    let numbers = [mtl.roughness, mtl.metallic, mtl.coat, mtl.sheen, mtl.anisotropy];
    numbers.iter().any(Option::is_some) || mtl.roughness_map.is_some() || mtl.metallic_map.is_some()
}

fn opaque(
    mtl: &MtlMaterial,
    diffuse: [f32; 3],
    textures: &mut MaterialTextures,
    warnings: &mut Warnings,
) -> MaterialModel {
    if is_physically_based(mtl) {
        return physically_based(mtl, diffuse, textures);
    }
    let texture = textures.diffuse.take();
    let is_black = |colour: [f32; 3]| colour.iter().all(|&c| c <= 0.0);
    let specular = mtl.specular.unwrap_or_default();
    let shines = !is_black(specular) && mtl.shininess.is_some_and(|n| n > 0.0);
    let mirrors = matches!(mtl.illumination_model, Some(3 | 5 | 8));
    let metallic_roughness = |base, texture, metallic: f32, roughness: f32| {
        MaterialModel::Layered(Box::new(LayeredDescription {
            base_colour: TexturedColour { colour: Colour::Rgb(base), texture },
            metallic: TexturedFactor::plain(metallic.clamp(0.0, 1.0)),
            roughness: TexturedFactor::plain(roughness.clamp(0.0, 1.0)),
            index: index(mtl),
            ..LayeredDescription::default()
        }))
    };
    if is_black(diffuse) && !is_black(specular) && mirrors {
        let base = reflectance(mtl, "Ks", specular, warnings);
        metallic_roughness(base, None, 1.0, mtl.shininess.map_or(0.0, roughness_of_exponent))
    } else if shines && !matches!(mtl.illumination_model, Some(0 | 1)) {
        metallic_roughness(diffuse, texture, 0.0, mtl.shininess.map_or(1.0, roughness_of_exponent))
    } else {
        MaterialModel::Diffuse { reflectance: TexturedColour { colour: Colour::Rgb(diffuse), texture } }
    }
}

fn emission(mtl: &MtlMaterial, texture: Option<TextureDescription>) -> Option<EmissionDescription> {
    let colour = mtl.emission.unwrap_or(if texture.is_some() { [1.0; 3] } else { [0.0; 3] }).map(|c| c.max(0.0));
    (colour != [0.0; 3]).then_some(EmissionDescription { colour: Colour::Rgb(colour), level: Some(1.0), texture })
}

/// Perceptual roughness of a Blinn–Phong exponent.
fn roughness_of_exponent(exponent: f32) -> f32 {
    (2.0 / (exponent.max(0.0) + 2.0)).powf(0.25)
}

/// A colour within 0–1; what is outside is cut off with a warning.
fn reflectance(mtl: &MtlMaterial, key: &str, colour: [f32; 3], warnings: &mut Warnings) -> [f32; 3] {
    if colour.iter().any(|c| !(0.0..=1.0).contains(c)) {
        let name = &mtl.name;
        warnings.once(format!("material {name:?}: {key} {colour:?} is outside 0–1 and is cut off there"));
    }
    colour.map(|c| c.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(mtl: &MtlMaterial) -> MaterialModel {
        describe(mtl, MaterialTextures::default(), &mut Warnings::default()).model
    }

    #[test]
    fn the_table_of_the_module_holds() {
        let plain = MtlMaterial { diffuse: Some([0.2, 0.4, 0.6]), ..MtlMaterial::default() };
        assert!(
            matches!(model(&plain), MaterialModel::Diffuse { reflectance } if matches!(reflectance.colour, Colour::Rgb([0.2, 0.4, 0.6])))
        );
        let layers = |mtl: &MtlMaterial| {
            let MaterialModel::Layered(layers) = model(mtl) else { panic!("not layered") };
            (layers.metallic.value, layers.roughness.value)
        };
        let shiny = MtlMaterial { specular: Some([0.5; 3]), shininess: Some(30.0), ..plain.clone() };
        // α = √(2/32) = 1/4, so the perceptual roughness is 1/2.
        let (metallic, roughness) = layers(&shiny);
        assert!(metallic == 0.0 && (roughness - 0.5).abs() < 1e-6);
        let matt = MtlMaterial { illumination_model: Some(1), ..shiny.clone() };
        assert!(matches!(model(&matt), MaterialModel::Diffuse { .. }));
        let mirror = MtlMaterial { diffuse: Some([0.0; 3]), illumination_model: Some(3), ..shiny };
        assert_eq!(layers(&mirror).0, 1.0);
        let modern = MtlMaterial { roughness: Some(0.3), metallic: Some(0.7), ..plain.clone() };
        assert_eq!(layers(&modern), (0.7, 0.3));
        for (illumination_model, opacity) in [(Some(7), None), (Some(2), Some(0.3)), (None, Some(0.1))] {
            let glass = MtlMaterial { index: Some(1.5), illumination_model, opacity, ..plain.clone() };
            assert!(matches!(model(&glass), MaterialModel::Dielectric { .. }));
        }
        let opaque = MtlMaterial { index: Some(1.45), illumination_model: Some(2), opacity: Some(1.0), ..plain };
        assert!(matches!(model(&opaque), MaterialModel::Diffuse { .. }));
    }

    #[test]
    fn opacity_without_an_index_is_a_blend() {
        let veil = MtlMaterial { opacity: Some(0.25), ..MtlMaterial::default() };
        let material = describe(&veil, MaterialTextures::default(), &mut Warnings::default());
        assert_eq!((material.alpha, material.alpha_factor), (AlphaMode::Blend, 0.25));
    }

    #[test]
    fn impossible_reflectances_are_cut_off_with_a_warning() {
        let mut warnings = Warnings::default();
        let bright = MtlMaterial { diffuse: Some([1.5, 0.5, -0.1]), ..MtlMaterial::default() };
        let material = describe(&bright, MaterialTextures::default(), &mut warnings);
        assert!(
            matches!(material.model, MaterialModel::Diffuse { reflectance } if matches!(reflectance.colour, Colour::Rgb([1.0, 0.5, 0.0])))
        );
        assert_eq!(warnings.into_messages().len(), 1);
    }
}
