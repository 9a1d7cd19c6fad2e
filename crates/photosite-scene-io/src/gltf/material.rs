//! Materials: metallic-roughness with its maps and the `KHR_materials_*` extensions, emission, alpha.

use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{AlphaMode as GltfAlphaMode, Material, NormalTexture};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;

use super::extensions::{self, extension};
use super::texture::{TextureUse, Textures};
use crate::stand_in::Holds;
use photosite_core::Invalid;
use photosite_core::spectrum::upsampling::reflectance_spectrum;
use photosite_core::spectrum::{Dispersion, Spectrum};
use photosite_core::warnings::Warnings;
use photosite_transport::scene::description::{
    AlphaMode, AnisotropyDescription, Channel, CoatDescription, Colour, Diffuse, EmissionDescription, FilmDescription,
    LayeredDescription, MaterialDescription, MaterialModel, TextureDescription, TexturedColour, TexturedFactor,
};

const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

/// Luminance of the white of unlit materials, nit: that of the display that sRGB is defined for (IEC 61966-2-1, the
/// reference viewing conditions). Unlit materials emit the light that the display would show.
const UNLIT_WHITE_NIT: f64 = 80.0;

/// Reads material number `index`.
pub(super) fn read_material(
    material: &Material,
    index: usize,
    textures: &mut Textures<'_>,
    warnings: &mut Warnings,
) -> Result<MaterialDescription, Invalid> {
    let key = format!("materials[{index}]");
    let mut reader = Reader { material, key: key.clone(), textures, warnings };
    let Base { mut layers, alpha_factor } = match reader.extension("KHR_materials_pbrSpecularGlossiness")? {
        Some(table) => reader.specular_glossiness(&table)?,
        None => reader.metallic_roughness()?,
    };
    let unlit: Option<serde_json::Value> = reader.extension("KHR_materials_unlit")?;
    let mut emission = None;
    let base_texture = layers.base_colour.texture.clone();
    let model = if unlit.is_some() {
        let TexturedColour { colour, texture } = layers.base_colour;
        emission = Some(EmissionDescription { colour, level: Some(UNLIT_WHITE_NIT), texture });
        MaterialModel::Diffuse(Diffuse { reflectance: TexturedColour::plain(Colour::Rgb([0.0; 3])) })
    } else {
        reader.layers(&mut layers)?;
        MaterialModel::Layered(Box::new(layers))
    };
    let normal_map = match &material.normal_texture {
        Some(normal) => Some(reader.normal_map(normal, "normalTexture")?),
        None => None,
    };
    let emissive_texture = reader.texture(&material.emissive_texture, Holds::Colours, "emissiveTexture")?;
    if emission.is_none() {
        emission = read_emission(material, &key, emissive_texture)?;
    }
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
    Ok(MaterialDescription {
        normal_map,
        emission,
        alpha,
        alpha_factor,
        alpha_texture: if alpha == AlphaMode::Opaque { None } else { base_texture },
        double_sided: material.double_sided,
        ..MaterialDescription::new(material.name.clone().unwrap_or_else(|| format!("material-{index}")), model)
    })
}

/// Default material of glTF for meshes without one: white, a metal of roughness 1.
pub(super) fn default_material() -> MaterialDescription {
    let layers = LayeredDescription { metallic: TexturedFactor::plain(1.0), ..LayeredDescription::default() };
    MaterialDescription::new("default", MaterialModel::Layered(Box::new(layers)))
}

/// Layers of either basic model, and the alpha of the whole.
struct Base {
    layers: LayeredDescription,
    alpha_factor: f32,
}

/// Reader of one material. Keys are relative to it.
struct Reader<'a, 'b> {
    material: &'a Material,
    key: String,
    textures: &'a mut Textures<'b>,
    warnings: &'a mut Warnings,
}

impl Reader<'_, '_> {
    fn extension<T: serde::de::DeserializeOwned>(&self, name: &str) -> Result<Option<T>, Invalid> {
        extension(self.material, name, &self.key)
    }

    fn metallic_roughness(&mut self) -> Result<Base, Invalid> {
        let pbr = &self.material.pbr_metallic_roughness;
        let at = |name: &str| format!("pbrMetallicRoughness.{name}");
        let [r, g, b, a] = pbr.base_color_factor.0;
        let map = self.texture(&pbr.metallic_roughness_texture, Holds::Factors, &at("metallicRoughnessTexture"))?;
        let of_map = |channel| map.clone().map(|map| (map, channel));
        let layers = LayeredDescription {
            base_colour: self.colour(
                [r, g, b],
                &at("baseColorFactor"),
                &pbr.base_color_texture,
                &at("baseColorTexture"),
            )?,
            metallic: TexturedFactor {
                value: self.unit(pbr.metallic_factor.0, &at("metallicFactor"))?,
                texture: of_map(Channel::B),
            },
            roughness: TexturedFactor {
                value: self.unit(pbr.roughness_factor.0, &at("roughnessFactor"))?,
                texture: of_map(Channel::G),
            },
            ..LayeredDescription::default()
        };
        Ok(Base { layers, alpha_factor: self.unit(a, &at("baseColorFactor"))? })
    }

    /// Layers of the deprecated specular-glossiness model, converted as in `KHR_materials_specular`,
    /// "Specular-glossiness materials": no metal, F₀ the specular colour, the diffuse colour under it.
    fn specular_glossiness(&mut self, table: &extensions::SpecularGlossiness) -> Result<Base, Invalid> {
        let at = |name: &str| format!("extensions.KHR_materials_pbrSpecularGlossiness.{name}");
        let [r, g, b, a] = table.diffuse_factor;
        let glossiness = self.unit(table.glossiness_factor, &at("glossinessFactor"))?;
        let map = &table.specular_glossiness_texture;
        let roughness = match map {
            Some(info) => {
                let key = format!("{}.{}", self.key, at("specularGlossinessTexture"));
                let texture = self.textures.describe_roughness(texture_use(info), glossiness, &key)?;
                TexturedFactor { value: 1.0, texture: Some((texture, Channel::G)) }
            }
            None => TexturedFactor::plain(1.0 - glossiness),
        };
        let layers = LayeredDescription {
            base_colour: self.colour([r, g, b], &at("diffuseFactor"), &table.diffuse_texture, &at("diffuseTexture"))?,
            roughness,
            normal_reflectance: Some(1.0),
            specular_colour: self.colour(
                table.specular_factor,
                &at("specularFactor"),
                map,
                &at("specularGlossinessTexture"),
            )?,
            ..LayeredDescription::default()
        };
        Ok(Base { layers, alpha_factor: self.unit(a, &at("diffuseFactor"))? })
    }

    /// Adds the layers of the extensions.
    fn layers(&mut self, layers: &mut LayeredDescription) -> Result<(), Invalid> {
        self.index(layers)?;
        self.specular(layers)?;
        self.behind(layers)?;
        layers.anisotropy = self.anisotropy()?;
        layers.film = self.film()?;
        layers.sheen = self.sheen()?;
        layers.coat = self.coat()?;
        Ok(())
    }

    fn index(&mut self, layers: &mut LayeredDescription) -> Result<(), Invalid> {
        let ior = self.extension::<extensions::Ior>("KHR_materials_ior")?.unwrap_or_default().ior;
        let key = format!("{}.extensions.KHR_materials_ior.ior", self.key);
        if ior == 0.0 {
            // "Extending Materials": a special value, for F = 1 before the specular colour.
            layers.normal_reflectance = Some(1.0);
            return Ok(());
        }
        if !(ior.is_finite() && ior >= 1.0) {
            return Err(Invalid::new(key, format!("must be at least 1, got {ior}"))
                .help("water has 1.33, glass 1.5; 0 stands for a reflectance that the specular colour gives alone"));
        }
        let dispersion = self.extension::<extensions::Dispersion>("KHR_materials_dispersion")?.unwrap_or_default();
        let dispersion = self.not_negative(dispersion.dispersion, "extensions.KHR_materials_dispersion.dispersion")?;
        layers.index = if dispersion > 0.0 {
            // "Extending Materials": 20 over the Abbe number.
            let table = Dispersion::from_abbe(f64::from(ior), 20.0 / f64::from(dispersion));
            let table = table.map_err(|e| e.within(&key))?;
            // "Overview": never below 1.
            Dispersion::Table(table.to_spectrum().map(|_, n| n.max(1.0)))
        } else {
            Dispersion::constant(f64::from(ior))
        };
        Ok(())
    }

    fn specular(&mut self, layers: &mut LayeredDescription) -> Result<(), Invalid> {
        let Some(table) = self.extension::<extensions::Specular>("KHR_materials_specular")? else { return Ok(()) };
        let at = |name: &str| format!("extensions.KHR_materials_specular.{name}");
        layers.specular = TexturedFactor {
            value: self.unit(table.specular_factor, &at("specularFactor"))?,
            texture: self.channel(&table.specular_texture, Channel::A, &at("specularTexture"))?,
        };
        for value in table.specular_color_factor {
            self.not_negative(value, &at("specularColorFactor"))?;
        }
        layers.specular_colour = TexturedColour {
            colour: Colour::Rgb(table.specular_color_factor),
            texture: self.texture(&table.specular_color_texture, Holds::Colours, &at("specularColorTexture"))?,
        };
        Ok(())
    }

    /// Adds transmission, diffuse transmission and volume.
    fn behind(&mut self, layers: &mut LayeredDescription) -> Result<(), Invalid> {
        if let Some(table) = self.extension::<extensions::Transmission>("KHR_materials_transmission")? {
            let at = |name: &str| format!("extensions.KHR_materials_transmission.{name}");
            layers.transmission = TexturedFactor {
                value: self.unit(table.transmission_factor, &at("transmissionFactor"))?,
                texture: self.channel(&table.transmission_texture, Channel::R, &at("transmissionTexture"))?,
            };
        }
        if let Some(t) = self.extension::<extensions::DiffuseTransmission>("KHR_materials_diffuse_transmission")? {
            let at = |name: &str| format!("extensions.KHR_materials_diffuse_transmission.{name}");
            let texture = &t.diffuse_transmission_texture;
            let factor = TexturedFactor {
                value: self.unit(t.diffuse_transmission_factor, &at("diffuseTransmissionFactor"))?,
                texture: self.channel(texture, Channel::A, &at("diffuseTransmissionTexture"))?,
            };
            let colour = self.colour(
                t.diffuse_transmission_color_factor,
                &at("diffuseTransmissionColorFactor"),
                &t.diffuse_transmission_color_texture,
                &at("diffuseTransmissionColorTexture"),
            )?;
            layers.diffuse_transmission = (factor.value > 0.0).then_some((factor, colour));
        }
        let Some(table) = self.extension::<extensions::Volume>("KHR_materials_volume")? else { return Ok(()) };
        let at = |name: &str| format!("extensions.KHR_materials_volume.{name}");
        // "Properties": without thickness the surface is a thin sheet.
        if self.not_negative(table.thickness_factor, &at("thicknessFactor"))? > 0.0 {
            let colour = self.rgb(table.attenuation_color, &at("attenuationColor"))?;
            let distance = table.attenuation_distance;
            if distance.is_nan() || distance <= 0.0 {
                let message = format!("must be above 0, got {distance}");
                return Err(Invalid::new(format!("{}.{}", self.key, at("attenuationDistance")), message)
                    .help("the distance in metres after which white light has the attenuationColor"));
            }
            layers.absorption_per_m = Some(absorption(colour, f64::from(distance)));
        }
        Ok(())
    }

    fn anisotropy(&mut self) -> Result<Option<AnisotropyDescription>, Invalid> {
        let Some(table) = self.extension::<extensions::Anisotropy>("KHR_materials_anisotropy")? else {
            return Ok(None);
        };
        let at = |name: &str| format!("extensions.KHR_materials_anisotropy.{name}");
        let rotation = at("anisotropyRotation");
        let anisotropy = AnisotropyDescription {
            strength: self.unit(table.anisotropy_strength, &at("anisotropyStrength"))?,
            rotation_rad: finite(table.anisotropy_rotation, &format!("{}.{rotation}", self.key))?,
            texture: self.texture(&table.anisotropy_texture, Holds::Directions, &at("anisotropyTexture"))?,
        };
        Ok((anisotropy.strength > 0.0).then_some(anisotropy))
    }

    fn film(&mut self) -> Result<Option<FilmDescription>, Invalid> {
        let Some(table) = self.extension::<extensions::Iridescence>("KHR_materials_iridescence")? else {
            return Ok(None);
        };
        let at = |name: &str| format!("extensions.KHR_materials_iridescence.{name}");
        if !(table.iridescence_ior.is_finite() && table.iridescence_ior >= 1.0) {
            let message = format!("must be at least 1, got {}", table.iridescence_ior);
            return Err(
                Invalid::new(format!("{}.{}", self.key, at("iridescenceIor")), message).help("water has 1.33, oil 1.5")
            );
        }
        let film = FilmDescription {
            weight: TexturedFactor {
                value: self.unit(table.iridescence_factor, &at("iridescenceFactor"))?,
                texture: self.channel(&table.iridescence_texture, Channel::R, &at("iridescenceTexture"))?,
            },
            index: table.iridescence_ior,
            thickness_nm: [
                self.not_negative(table.iridescence_thickness_minimum, &at("iridescenceThicknessMinimum"))?,
                self.not_negative(table.iridescence_thickness_maximum, &at("iridescenceThicknessMaximum"))?,
            ],
            thickness_texture: self.texture(
                &table.iridescence_thickness_texture,
                Holds::Factors,
                &at("iridescenceThicknessTexture"),
            )?,
        };
        Ok((film.weight.value > 0.0).then_some(film))
    }

    fn sheen(&mut self) -> Result<Option<(TexturedColour, TexturedFactor)>, Invalid> {
        let Some(table) = self.extension::<extensions::Sheen>("KHR_materials_sheen")? else { return Ok(None) };
        let at = |name: &str| format!("extensions.KHR_materials_sheen.{name}");
        let colour = self.colour(
            table.sheen_color_factor,
            &at("sheenColorFactor"),
            &table.sheen_color_texture,
            &at("sheenColorTexture"),
        )?;
        let roughness = TexturedFactor {
            value: self.unit(table.sheen_roughness_factor, &at("sheenRoughnessFactor"))?,
            texture: self.channel(&table.sheen_roughness_texture, Channel::A, &at("sheenRoughnessTexture"))?,
        };
        Ok((table.sheen_color_factor != [0.0; 3]).then_some((colour, roughness)))
    }

    fn coat(&mut self) -> Result<Option<CoatDescription>, Invalid> {
        let Some(table) = self.extension::<extensions::Clearcoat>("KHR_materials_clearcoat")? else { return Ok(None) };
        let at = |name: &str| format!("extensions.KHR_materials_clearcoat.{name}");
        let map = &table.clearcoat_roughness_texture;
        let coat = CoatDescription {
            weight: TexturedFactor {
                value: self.unit(table.clearcoat_factor, &at("clearcoatFactor"))?,
                texture: self.channel(&table.clearcoat_texture, Channel::R, &at("clearcoatTexture"))?,
            },
            roughness: TexturedFactor {
                value: self.unit(table.clearcoat_roughness_factor, &at("clearcoatRoughnessFactor"))?,
                texture: self.channel(map, Channel::G, &at("clearcoatRoughnessTexture"))?,
            },
            normal_map: match &table.clearcoat_normal_texture {
                Some(normal) => Some(self.normal_map(normal, &at("clearcoatNormalTexture"))?),
                None => None,
            },
        };
        Ok((coat.weight.value > 0.0).then_some(coat))
    }

    fn texture(&mut self, info: &Option<Info>, holds: Holds, key: &str) -> Result<Option<TextureDescription>, Invalid> {
        let key = format!("{}.{key}", self.key);
        info.as_ref().map(|info| self.textures.describe(texture_use(info), holds, &key)).transpose()
    }

    fn channel(
        &mut self,
        info: &Option<Info>,
        channel: Channel,
        key: &str,
    ) -> Result<Option<(TextureDescription, Channel)>, Invalid> {
        Ok(self.texture(info, Holds::Factors, key)?.map(|texture| (texture, channel)))
    }

    fn colour(
        &mut self,
        rgb: [f32; 3],
        key: &str,
        info: &Option<Info>,
        texture_key: &str,
    ) -> Result<TexturedColour, Invalid> {
        let texture = self.texture(info, Holds::Colours, texture_key)?;
        Ok(TexturedColour { colour: Colour::Rgb(self.rgb(rgb, key)?), texture })
    }

    fn rgb(&mut self, [r, g, b]: [f32; 3], key: &str) -> Result<[f32; 3], Invalid> {
        Ok([self.unit(r, key)?, self.unit(g, key)?, self.unit(b, key)?])
    }

    fn normal_map(&mut self, normal: &NormalTexture, key: &str) -> Result<(TextureDescription, f32), Invalid> {
        let key = format!("{}.{key}", self.key);
        // The parser types this extension for all textures but this one.
        let transform: Option<TextureTransform> = normal
            .extensions
            .as_ref()
            .and_then(|e| e.others.get(TEXTURE_TRANSFORM))
            .map(|value| serde_json::from_value(value.clone()))
            .transpose()
            .map_err(|source| Invalid::new(format!("{key}.extensions.{TEXTURE_TRANSFORM}"), source.to_string()))?;
        let used =
            TextureUse { texture: normal.index.value(), uv_set: normal.tex_coord, transform: transform.as_ref() };
        Ok((self.textures.describe(used, Holds::Normals, &key)?, finite(normal.scale, &format!("{key}.scale"))?))
    }

    /// A factor that should lie in 0–1. Some programs write a little more, which is clamped with a warning.
    fn unit(&mut self, value: f32, key: &str) -> Result<f32, Invalid> {
        let key = format!("{}.{key}", self.key);
        let value = finite(value, &key)?;
        if !(0.0..=1.0).contains(&value) {
            self.warnings.once(format!("{key} is {value}, outside 0–1, and is taken to be {}", value.clamp(0.0, 1.0)));
        }
        Ok(value.clamp(0.0, 1.0))
    }

    fn not_negative(&self, value: f32, key: &str) -> Result<f32, Invalid> {
        not_negative(value, format!("{}.{key}", self.key))
    }
}

/// Absorption that gives white light `colour` after `distance` metres (`volume`, "Attenuation"): σ =
/// −ln(colour)/distance at every wavelength, m⁻¹.
fn absorption(colour: [f32; 3], distance: f64) -> Spectrum {
    // Perfect absorption would be infinite; what is left of a billionth is nothing to any sensor.
    const DARKEST: f64 = 1e-9;
    reflectance_spectrum(colour).map(|_, c| -c.clamp(DARKEST, 1.0).ln() / distance)
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
    for value in factor {
        not_negative(value, format!("{key}.emissiveFactor"))?;
    }
    not_negative(strength, format!("{key}.extensions.KHR_materials_emissive_strength.emissiveStrength"))?;
    if strength == 0.0 || factor == [0.0; 3] {
        return Ok(None);
    }
    Ok(Some(EmissionDescription { colour: Colour::Rgb(factor), level: Some(f64::from(strength)), texture }))
}

fn texture_use(info: &Info) -> TextureUse<'_> {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
    TextureUse { texture: info.index.value(), uv_set: info.tex_coord, transform }
}

fn finite(value: f32, key: &str) -> Result<f32, Invalid> {
    if value.is_finite() { Ok(value) } else { Err(Invalid::new(key, format!("is not finite: {value}"))) }
}

fn not_negative(value: f32, key: String) -> Result<f32, Invalid> {
    match finite(value, &key)? {
        value if value < 0.0 => Err(Invalid::new(key, format!("must not be negative, got {value}"))),
        value => Ok(value),
    }
}
