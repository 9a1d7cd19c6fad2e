//! What MTL materials mean physically. The format describes formulas of the early nineties; this is the reading:
//!
//! | the file says | it is taken as |
//! |---|---|
//! | `Pr` or `Pm` | metallic-roughness with these and the colour `Kd` |
//! | `Ni` > 1 and (`illum` 4, 6, 7, 9 or `d` < 1), no `map_d` | clear glass of index `Ni`, its colour left out |
//! | `Kd` black, `Ks` not, `illum` 3, 5 or 8 | a mirroring metal of colour `Ks` |
//! | `Ks` not black and `Ns` > 0, `illum` not 0 or 1 | plastic of colour `Kd`: metallic-roughness, not metallic |
//! | otherwise | diffuse of colour `Kd` |
//!
//! `Ns` is the exponent n of a Blinn–Phong lobe, of which α = √(2/(n + 2)) is the microfacet roughness
//! ([Walter07](crate::references#walter07) §5.2), so the perceptual roughness is √α. `d` below 1 lets through a part of
//! the light (`Blend`) unless it is glass. `Ke` is in nit. Surfaces scatter on both sides, since the format has no
//! notion of a front.

use super::mtl::MtlMaterial;
use crate::io::warnings::Warnings;
use crate::scene::description::{
    AlphaMode, Colour, EmissionDescription, LayeredDescription, MaterialDescription, MaterialModel, TextureDescription,
    TexturedColour, TexturedFactor,
};
use crate::spectrum::Dispersion;

/// The textures of a material, its pictures already among the scene's.
#[derive(Debug, Default)]
pub(super) struct MaterialTextures {
    pub(super) diffuse: Option<TextureDescription>,
    pub(super) emission: Option<TextureDescription>,
    pub(super) opacity: Option<TextureDescription>,
    pub(super) normal: Option<TextureDescription>,
}

/// Reflectance of surfaces of which nothing is known.
const DEFAULT_REFLECTANCE: f32 = 0.5;

/// A diffuse grey material, for faces whose material is not described.
pub(super) fn undescribed(name: &str) -> MaterialDescription {
    let reflectance = TexturedColour::plain(Colour::Rgb([DEFAULT_REFLECTANCE; 3]));
    MaterialDescription { double_sided: true, ..MaterialDescription::new(name, MaterialModel::Diffuse { reflectance }) }
}

/// The material that the module's table gives.
pub(super) fn describe(mtl: &MtlMaterial, textures: MaterialTextures, warnings: &mut Warnings) -> MaterialDescription {
    let diffuse = match (mtl.diffuse, &textures.diffuse) {
        (Some(colour), _) => reflectance(mtl, "Kd", colour, warnings),
        (None, Some(_)) => [1.0; 3],
        (None, None) => [DEFAULT_REFLECTANCE; 3],
    };
    let opacity = mtl.opacity.unwrap_or(1.0).clamp(0.0, 1.0);
    let is_glass = is_glass(mtl);
    let see_through = !is_glass && (opacity < 1.0 || textures.opacity.is_some());
    MaterialDescription {
        name: mtl.name.clone(),
        model: if is_glass { glass(mtl) } else { opaque(mtl, diffuse, textures.diffuse, warnings) },
        normal_map: textures.normal.map(|texture| (texture, 1.0)),
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
    MaterialModel::Dielectric {
        index: Dispersion::constant(f64::from(mtl.index.unwrap_or(1.5))),
        roughness: mtl.roughness.unwrap_or(0.0).clamp(0.0, 1.0),
    }
}

fn opaque(
    mtl: &MtlMaterial,
    diffuse: [f32; 3],
    texture: Option<TextureDescription>,
    warnings: &mut Warnings,
) -> MaterialModel {
    let is_black = |colour: [f32; 3]| colour.iter().all(|&c| c <= 0.0);
    let specular = mtl.specular.unwrap_or_default();
    let shines = !is_black(specular) && mtl.shininess.is_some_and(|n| n > 0.0);
    let mirrors = matches!(mtl.illumination_model, Some(3 | 5 | 8));
    let metallic_roughness = |base, texture, metallic: f32, roughness: f32| {
        MaterialModel::Layered(Box::new(LayeredDescription {
            base_colour: TexturedColour { colour: Colour::Rgb(base), texture },
            metallic: TexturedFactor::plain(metallic.clamp(0.0, 1.0)),
            roughness: TexturedFactor::plain(roughness.clamp(0.0, 1.0)),
            ..LayeredDescription::default()
        }))
    };
    if mtl.roughness.is_some() || mtl.metallic.is_some() {
        let roughness = mtl.roughness.or(mtl.shininess.map(roughness_of_exponent)).unwrap_or(0.5);
        metallic_roughness(diffuse, texture, mtl.metallic.unwrap_or(0.0), roughness)
    } else if is_black(diffuse) && !is_black(specular) && mirrors {
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
