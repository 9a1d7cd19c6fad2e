//! The `KHR_materials_*` extensions as found in files, with the defaults of their schemas.

use gltf::json::material::{Material, NormalTexture};
use gltf::json::texture::Info;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use photosite_core::Invalid;

/// The extension `name` of a material, if it is there. `key` names the material.
pub(super) fn extension<T: DeserializeOwned>(material: &Material, name: &str, key: &str) -> Result<Option<T>, Invalid> {
    let value = material.extensions.as_ref().and_then(|e| e.others.get(name));
    value
        .map(|value| serde_json::from_value(value.clone()))
        .transpose()
        .map_err(|source| Invalid::new(format!("{key}.extensions.{name}"), source.to_string()))
}

/// Declares an extension: fields that are textures, and fields with defaults.
macro_rules! extension {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty = $default:expr),* $(; $($texture:ident),*)? $(; normal $normal:ident)? }) => {
        $(#[$doc])*
        #[derive(Debug, Deserialize)]
        #[serde(default, rename_all = "camelCase")]
        pub(super) struct $name {
            $(pub(super) $field: $type,)*
            $($(pub(super) $texture: Option<Info>,)*)?
            $(pub(super) $normal: Option<NormalTexture>,)?
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* $($($texture: None,)*)? $($normal: None,)? }
            }
        }
    };
}

extension! {
    /// Extension `KHR_materials_ior`.
    Ior { ior: f32 = 1.5 }
}
extension! {
    /// Extension `KHR_materials_dispersion`: 20 over the Abbe number.
    Dispersion { dispersion: f32 = 0.0 }
}
extension! {
    /// Extension `KHR_materials_specular`.
    Specular {
        specular_factor: f32 = 1.0, specular_color_factor: [f32; 3] = [1.0; 3];
        specular_texture, specular_color_texture
    }
}
extension! {
    /// Extension `KHR_materials_transmission`.
    Transmission { transmission_factor: f32 = 0.0; transmission_texture }
}
extension! {
    /// Extension `KHR_materials_volume`. Its texture is for renderers that cannot measure path lengths inside.
    Volume {
        thickness_factor: f32 = 0.0, attenuation_distance: f32 = f32::INFINITY, attenuation_color: [f32; 3] = [1.0; 3]
    }
}
extension! {
    /// Extension `KHR_materials_diffuse_transmission`.
    DiffuseTransmission {
        diffuse_transmission_factor: f32 = 0.0, diffuse_transmission_color_factor: [f32; 3] = [1.0; 3];
        diffuse_transmission_texture, diffuse_transmission_color_texture
    }
}
extension! {
    /// Extension `KHR_materials_clearcoat`.
    Clearcoat {
        clearcoat_factor: f32 = 0.0, clearcoat_roughness_factor: f32 = 0.0;
        clearcoat_texture, clearcoat_roughness_texture;
        normal clearcoat_normal_texture
    }
}
extension! {
    /// Extension `KHR_materials_sheen`.
    Sheen {
        sheen_color_factor: [f32; 3] = [0.0; 3], sheen_roughness_factor: f32 = 0.0;
        sheen_color_texture, sheen_roughness_texture
    }
}
extension! {
    /// Extension `KHR_materials_anisotropy`.
    Anisotropy { anisotropy_strength: f32 = 0.0, anisotropy_rotation: f32 = 0.0; anisotropy_texture }
}
extension! {
    /// Extension `KHR_materials_iridescence`.
    Iridescence {
        iridescence_factor: f32 = 0.0, iridescence_ior: f32 = 1.3,
        iridescence_thickness_minimum: f32 = 100.0, iridescence_thickness_maximum: f32 = 400.0;
        iridescence_texture, iridescence_thickness_texture
    }
}
extension! {
    /// Extension `KHR_materials_pbrSpecularGlossiness`.
    SpecularGlossiness {
        diffuse_factor: [f32; 4] = [1.0; 4], specular_factor: [f32; 3] = [1.0; 3], glossiness_factor: f32 = 1.0;
        diffuse_texture, specular_glossiness_texture
    }
}
