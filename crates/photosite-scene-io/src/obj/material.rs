//! Physical meaning of MTL materials. The format describes formulas of the early nineties
//! ([Mtl95](photosite_core::references#mtl95)) and was extended by the parameters of Burley's model
//! ([Houston15](photosite_core::references#houston15)); the first row that fits applies:
//!
//! | the file says | it is taken as |
//! |---|---|
//! | `Ni` > 1, and `illum` 6 or 7 or, without `illum`, `d` < 1; no `map_d` | clear glass of index `Ni`, tinted `Tf` where light passes its surface |
//! | `Pr`, `Pm`, `Pc`, `Ps`, `aniso`, or a map of the first four | glTF's material with these and the colour `Kd` |
//! | `illum` 3, 5 or 8 (which reflect the surroundings) and `Ks` not black | facets of F₀ = `Ks` over the colour `Kd`; where that is black, a metal of colour `Ks` |
//! | `Ks` not black and `Ns` > 0, `illum` not 0 or 1 | plastic of colour `Kd` |
//! | otherwise | diffuse of colour `Kd` |
//!
//! Plastic and glTF's material have the index `Ni` where it is above 1, else 1.5, and reflect 2·`Ks` of what it gives:
//! Burley's "specular", whose ½ is an ordinary surface and what programs write; without `Ks` that. `Ns` is the exponent
//! n of a Blinn–Phong lobe, of which α = √(2/(n + 2)) is the microfacet roughness
//! ([Walter07](photosite_core::references#walter07) §5.2), so the perceptual roughness is √α; `Pr` goes first.
//!
//! `Tr` stands for 1 − `d` where there is no `d`, but for 1, which programs write of opaque surfaces. `d` below 1 or
//! `map_d` leave that part of the surface there and nothing of the rest (`Blend`), unless it is glass.
//! With a coloured `Tf` the rest is a filter of that colour instead. `Pc` and `Pcr` are weight and roughness of a coat,
//! `Ps` the weight of white sheen of roughness 0.5 (assumed: the format has no key for it), `aniso` 0–1 and `anisor`
//! (in turns) strength and rotation of grooves. `-bm` scales the bumps of `norm`; in `bump` it is the height of white
//! in texels (assumed: the format has no unit for it). `Ke` is in nit. Surfaces scatter on both sides, since the format
//! has no notion of a front. `illum` 0, a colour without light, is diffuse: light from nowhere is left out.

use super::material_textures::MaterialTextures;
use super::mtl::{MtlMaterial, roughness_of_exponent};
use crate::assemble::DEFAULT_REFLECTANCE;
use photosite_core::spectrum::upsampling::reflectance_spectrum;
use photosite_core::spectrum::{Dispersion, Spectrum};
use photosite_core::warnings::Warnings;
use photosite_transport::scene::description::{
    AlphaMode, AnisotropyDescription, Channel, CoatDescription, Colour, Dielectric, Diffuse, EmissionDescription,
    LayeredDescription, MaterialDescription, MaterialModel, Mix, Roughness, TextureDescription, TexturedColour,
    TexturedFactor, ThinDielectric,
};

/// Perceptual roughness of sheen, which the format does not define.
const SHEEN_ROUGHNESS: f32 = 0.5;

/// Value of `Ks` for a surface that reflects as its index demands.
const ORDINARY_SPECULAR: f32 = 0.5;

const WHITE: [f32; 3] = [1.0; 3];

/// Material by the table of this module.
pub(super) fn describe(
    mtl: &MtlMaterial,
    mut textures: MaterialTextures,
    warnings: &mut Warnings,
) -> MaterialDescription {
    let emission = emission(mtl, textures.emission.take());
    let normal_map = textures.normal.take();
    let opacity = mtl.opacity.unwrap_or(1.0).clamp(0.0, 1.0);
    let opacity_map = textures.opacity.take();
    let mut material = MaterialDescription {
        normal_map,
        emission,
        double_sided: true,
        ..MaterialDescription::new(&mtl.name, if is_glass(mtl) { glass(mtl) } else { opaque(mtl, textures, warnings) })
    };
    match filter(mtl).filter(|_| opacity < 1.0 && opacity_map.is_none()) {
        _ if is_glass(mtl) => {}
        Some(filter) => {
            let (index, transmittance) = (Dispersion::constant(1.0), reflectance_spectrum(filter));
            let models = [material.model, MaterialModel::ThinDielectric(ThinDielectric { index, transmittance })];
            material.model = MaterialModel::Mix(Box::new(Mix { models, weight: 1.0 - opacity }));
        }
        None if opacity < 1.0 || opacity_map.is_some() => {
            (material.alpha, material.alpha_factor) = (AlphaMode::Blend, opacity);
            material.alpha_texture = opacity_map;
        }
        None => {}
    }
    material
}

fn is_glass(mtl: &MtlMaterial) -> bool {
    let refracts = match mtl.illumination_model {
        Some(model) => matches!(model, 6 | 7),
        None => mtl.opacity.is_some_and(|d| d < 1.0),
    };
    mtl.index.is_some_and(|index| index > 1.0) && refracts && mtl.opacity_map.is_none()
}

/// Transmission filter `Tf`, where it is a colour.
fn filter(mtl: &MtlMaterial) -> Option<[f32; 3]> {
    mtl.transmission_filter.map(|filter| filter.map(|c| c.clamp(0.0, 1.0))).filter(|filter| *filter != WHITE)
}

fn glass(mtl: &MtlMaterial) -> MaterialModel {
    let (index, roughness) = (index(mtl), unit(mtl.roughness, 0.0));
    match filter(mtl) {
        None => MaterialModel::Dielectric(Dielectric {
            index,
            distribution: Roughness::isotropic(roughness),
            energy_compensation: false,
        }),
        Some(filter) => MaterialModel::Layered(Box::new(LayeredDescription {
            kind: "MTL",
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

fn unit(value: Option<f32>, default: f32) -> f32 {
    value.unwrap_or(default).clamp(0.0, 1.0)
}

/// Factor and its map; a map without a factor is used alone.
fn factor(value: Option<f32>, texture: Option<TextureDescription>, otherwise: f32) -> TexturedFactor {
    let value = unit(value, if texture.is_some() { 1.0 } else { otherwise });
    TexturedFactor { value, texture: texture.map(|texture| (texture, Channel::R)) }
}

/// Colour and its map; a map without a colour is used alone.
fn colour(
    mtl: &MtlMaterial,
    (key, value): (&str, Option<[f32; 3]>),
    texture: Option<TextureDescription>,
    otherwise: f32,
    warnings: &mut Warnings,
) -> TexturedColour {
    let rgb = match value {
        Some(rgb) => reflectance(mtl, key, rgb, warnings),
        None if texture.is_some() => WHITE,
        None => [otherwise; 3],
    };
    TexturedColour { colour: Colour::Rgb(rgb), texture }
}

fn is_black(colour: &TexturedColour) -> bool {
    matches!(colour.colour, Colour::Rgb([0.0, 0.0, 0.0]))
}

fn opaque(mtl: &MtlMaterial, mut textures: MaterialTextures, warnings: &mut Warnings) -> MaterialModel {
    let diffuse = colour(mtl, ("Kd", mtl.diffuse), textures.diffuse.take(), DEFAULT_REFLECTANCE, warnings);
    let has_specular = mtl.specular.is_some() || textures.specular.is_some();
    let specular = colour(mtl, ("Ks", mtl.specular), textures.specular.take(), 0.0, warnings);
    let shines = mtl.shininess.is_some_and(|n| n > 0.0) || textures.roughness_of_exponent.is_some();
    let mirrors = matches!(mtl.illumination_model, Some(3 | 5 | 8));
    if is_physically_based(mtl) {
        let specular = has_specular.then_some(specular);
        return layered(physically_based(mtl, textures), diffuse, specular);
    }
    if is_black(&specular) || !mirrors && (!shines || matches!(mtl.illumination_model, Some(0 | 1))) {
        return MaterialModel::Diffuse(Diffuse { reflectance: diffuse });
    }
    let plain = LayeredDescription {
        kind: "MTL",
        roughness: roughness(mtl, &mut textures, if mirrors { 0.0 } else { 1.0 }),
        index: index(mtl),
        ..LayeredDescription::default()
    };
    match (mirrors, is_black(&diffuse)) {
        (false, _) => layered(plain, diffuse, Some(specular)),
        (true, true) => layered(LayeredDescription { metallic: TexturedFactor::plain(1.0), ..plain }, specular, None),
        (true, false) => MaterialModel::Layered(Box::new(LayeredDescription {
            base_colour: diffuse,
            normal_reflectance: Some(1.0),
            specular_colour: specular,
            ..plain
        })),
    }
}

/// Layers with these colours.
fn layered(layers: LayeredDescription, base_colour: TexturedColour, specular: Option<TexturedColour>) -> MaterialModel {
    let specular_colour = specular.map_or_else(TexturedColour::white, |specular| match specular.colour {
        Colour::Rgb(rgb) => TexturedColour { colour: Colour::Rgb(rgb.map(|c| c / ORDINARY_SPECULAR)), ..specular },
        Colour::Spectrum(_) => specular,
    });
    MaterialModel::Layered(Box::new(LayeredDescription { base_colour, specular_colour, ..layers }))
}

/// Layers of the physically based extension of the format, which resembles glTF, without colours.
fn physically_based(mtl: &MtlMaterial, mut textures: MaterialTextures) -> LayeredDescription {
    let coat = factor(mtl.coat, textures.coat.take(), 0.0);
    let sheen = unit(mtl.sheen, if textures.sheen.is_some() { 1.0 } else { 0.0 });
    let strength = unit(mtl.anisotropy, 0.0);
    LayeredDescription {
        kind: "MTL",
        metallic: factor(mtl.metallic, textures.metallic.take(), 0.0),
        roughness: roughness(mtl, &mut textures, 0.5),
        index: index(mtl),
        coat: (coat.value > 0.0).then(|| CoatDescription {
            weight: coat,
            roughness: factor(mtl.coat_roughness, textures.coat_roughness.take(), 0.0),
            normal_map: None,
        }),
        sheen: (sheen > 0.0).then(|| {
            let colour = TexturedColour { colour: Colour::Rgb([sheen; 3]), texture: textures.sheen.take() };
            (colour, TexturedFactor::plain(SHEEN_ROUGHNESS))
        }),
        anisotropy: (strength > 0.0).then(|| AnisotropyDescription {
            strength,
            rotation_rad: mtl.anisotropy_rotation.unwrap_or(0.0) * std::f32::consts::TAU,
            texture: None,
        }),
        ..LayeredDescription::default()
    }
}

/// Whether a key of the extension for physically based materials is there.
fn is_physically_based(mtl: &MtlMaterial) -> bool {
    let numbers = [mtl.roughness, mtl.metallic, mtl.coat, mtl.sheen, mtl.anisotropy];
    let maps = [&mtl.roughness_map, &mtl.metallic_map, &mtl.coat_map, &mtl.sheen_map];
    numbers.iter().any(Option::is_some) || maps.iter().any(|map| map.is_some())
}

/// Perceptual roughness: `Pr`, or else derived from `Ns`.
fn roughness(mtl: &MtlMaterial, textures: &mut MaterialTextures, otherwise: f32) -> TexturedFactor {
    let by_exponent = textures.roughness_of_exponent.take();
    if mtl.roughness.is_some() || textures.roughness.is_some() || by_exponent.is_none() {
        let otherwise = mtl.shininess.map_or(otherwise, roughness_of_exponent);
        return factor(mtl.roughness, textures.roughness.take(), otherwise);
    }
    factor(None, by_exponent, otherwise)
}

fn emission(mtl: &MtlMaterial, texture: Option<TextureDescription>) -> Option<EmissionDescription> {
    let colour = mtl.emission.unwrap_or(if texture.is_some() { WHITE } else { [0.0; 3] }).map(|c| c.max(0.0));
    (colour != [0.0; 3]).then_some(EmissionDescription { colour: Colour::Rgb(colour), level: Some(1.0), texture })
}

/// Colour clamped to 0–1 with a warning.
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

    fn layers(mtl: &MtlMaterial) -> LayeredDescription {
        let MaterialModel::Layered(layers) = model(mtl) else { panic!("{:?} is not layered", model(mtl)) };
        *layers
    }

    fn rgb(colour: &TexturedColour) -> [f32; 3] {
        let Colour::Rgb(rgb) = colour.colour else { panic!("{colour:?}") };
        rgb
    }

    fn plain() -> MtlMaterial {
        MtlMaterial { diffuse: Some([0.2, 0.4, 0.6]), ..MtlMaterial::default() }
    }

    fn shiny() -> MtlMaterial {
        MtlMaterial { specular: Some([0.5; 3]), shininess: Some(30.0), ..plain() }
    }

    #[test]
    fn matt_and_shiny_surfaces_are_told_apart() {
        for matt in [plain(), MtlMaterial { illumination_model: Some(1), ..shiny() }] {
            let MaterialModel::Diffuse(Diffuse { reflectance }) = model(&matt) else { panic!("{:?}", model(&matt)) };
            assert_eq!(rgb(&reflectance), [0.2, 0.4, 0.6]);
        }
        // α = √(2/32) = 1/4, so the perceptual roughness is 1/2; a Ks of ½ is an ordinary surface.
        let plastic = layers(&shiny());
        assert!(plastic.metallic.value == 0.0 && (plastic.roughness.value - 0.5).abs() < 1e-6);
        assert_eq!((rgb(&plastic.base_colour), rgb(&plastic.specular_colour)), ([0.2, 0.4, 0.6], WHITE));
        let tinted = layers(&MtlMaterial { specular: Some([1.0, 0.25, 0.0]), ..shiny() });
        assert_eq!(rgb(&tinted.specular_colour), [2.0, 0.5, 0.0]);
    }

    #[test]
    fn models_that_reflect_the_surroundings_mirror() {
        for illumination_model in [3, 5, 8].map(Some) {
            let lacquer = layers(&MtlMaterial { illumination_model, ..shiny() });
            assert_eq!((rgb(&lacquer.specular_colour), lacquer.normal_reflectance), ([0.5; 3], Some(1.0)));
            let metal = layers(&MtlMaterial { diffuse: Some([0.0; 3]), illumination_model, ..shiny() });
            assert_eq!((metal.metallic.value, rgb(&metal.base_colour)), (1.0, [0.5; 3]));
        }
    }

    #[test]
    fn keys_of_physically_based_materials_are_gltfs() {
        let modern = MtlMaterial { roughness: Some(0.3), metallic: Some(0.7), ..plain() };
        let found = layers(&modern);
        assert_eq!((found.metallic.value, found.roughness.value), (0.7, 0.3));
        assert_eq!(rgb(&found.specular_colour), WHITE);
        let all = layers(&MtlMaterial {
            coat: Some(0.5),
            coat_roughness: Some(0.2),
            sheen: Some(0.4),
            anisotropy: Some(0.6),
            anisotropy_rotation: Some(0.25),
            ..modern
        });
        let (coat, (sheen, _)) = (all.coat.expect("a coat"), all.sheen.expect("sheen"));
        assert_eq!((coat.weight.value, coat.roughness.value, rgb(&sheen)), (0.5, 0.2, [0.4; 3]));
        let grooves = all.anisotropy.expect("grooves");
        assert_eq!((grooves.strength, grooves.rotation_rad), (0.6, 0.25 * std::f32::consts::TAU));
    }

    #[test]
    fn refraction_needs_an_index_and_a_model_that_has_it() {
        let glass =
            |illumination_model, opacity| MtlMaterial { index: Some(1.5), illumination_model, opacity, ..plain() };
        for (illumination_model, opacity) in [(Some(6), None), (Some(7), Some(1.0)), (None, Some(0.1))] {
            let found = model(&glass(illumination_model, opacity));
            assert!(matches!(found, MaterialModel::Dielectric(_)), "{illumination_model:?}: {found:?}");
        }
        for (illumination_model, opacity) in [(Some(2), Some(1.0)), (Some(2), Some(0.3)), (Some(4), None), (None, None)]
        {
            let found = model(&glass(illumination_model, opacity));
            assert!(matches!(found, MaterialModel::Diffuse(_)), "{illumination_model:?}: {found:?}");
        }
        let stained = layers(&MtlMaterial { transmission_filter: Some([1.0, 0.2, 0.1]), ..glass(Some(7), None) });
        assert_eq!((rgb(&stained.base_colour), stained.transmission.value), ([1.0, 0.2, 0.1], 1.0));
    }

    #[test]
    fn opacity_is_a_blend_and_with_a_coloured_filter_a_mix() {
        let veil = MtlMaterial { opacity: Some(0.25), ..MtlMaterial::default() };
        let material = describe(&veil, MaterialTextures::default(), &mut Warnings::default());
        assert_eq!((material.alpha, material.alpha_factor), (AlphaMode::Blend, 0.25));
        let film = MtlMaterial { transmission_filter: Some([0.9, 0.2, 0.2]), ..veil };
        let material = describe(&film, MaterialTextures::default(), &mut Warnings::default());
        assert_eq!(material.alpha, AlphaMode::Opaque);
        let MaterialModel::Mix(mix) = &material.model else { panic!("{:?}", material.model) };
        assert!(matches!(mix.models[1], MaterialModel::ThinDielectric(_)) && mix.weight == 0.75);
    }

    #[test]
    fn impossible_reflectances_are_cut_off_with_a_warning() {
        let mut warnings = Warnings::default();
        let bright = MtlMaterial { diffuse: Some([1.5, 0.5, -0.1]), ..MtlMaterial::default() };
        let material = describe(&bright, MaterialTextures::default(), &mut warnings);
        assert!(
            matches!(material.model, MaterialModel::Diffuse(Diffuse { reflectance }) if rgb(&reflectance) == [1.0, 0.5, 0.0])
        );
        assert_eq!(warnings.into_messages().len(), 1);
    }
}
