//! `[materials.NAME]`.

use schemars::JsonSchema;
use serde::Deserialize;

use super::super::tree::nodes::Node;
use super::super::tree::source::CaptureSource;
use super::spectra::Finder;
use super::{LightColour, ReflectanceSource, TextureFile};
use photosite_core::keys::{Key, Keys};
use photosite_core::schema_range::{above, within};
use photosite_core::{Invalid, Result};
use photosite_sensor::{CurveFile, SpectrumSource};
use photosite_transport::scene::description::MaterialModel;

/// How a surface scatters light, in place of what the geometry's file says. Without a type, its own stays and only the
/// keys that are there change.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum MaterialTable {
    /// A material described anew.
    Typed(Box<TypedMaterialTable>),
    /// The geometry's own material with changes.
    Kept(Box<KeptTable>),
}

impl Key for MaterialTable {
    type Given = MaterialKeys;
}

impl From<KeptKeys> for MaterialKeys {
    fn from(keys: KeptKeys) -> Self {
        Self(keys.0)
    }
}

/// Makes what `type` chooses among, and reads it, from a list of types and their tables.
macro_rules! material_types {
    ($($(#[$doc:meta])* $kind:ident($table:ident),)*) => {
        /// A material described anew.
        #[derive(Debug, JsonSchema, Keys)]
        #[schemars(tag = "type", rename_all = "kebab-case")]
        #[keys(named = "MaterialKeys")]
        pub(crate) enum TypedMaterialTable {
            $($(#[$doc])* $kind($table),)*
            /// Two materials side by side, finer than the eye sees.
            Mix(MixTable),
        }

        /// The value of `type`.
        #[derive(Clone, Copy, Debug, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub(crate) enum MaterialType {
            $($kind,)*
            Mix,
        }

        impl TypedMaterialTable {
            /// Reads a table of a type; `mix` reads those of two others.
            pub(crate) fn read(
                kind: MaterialType,
                source: &CaptureSource,
                path: &str,
                node: Node,
                mix: impl FnOnce(Node) -> Result<MixTable>,
            ) -> Result<Self> {
                Ok(match kind {
                    $(MaterialType::$kind => Self::$kind(source.read_node(path, &node)?),)*
                    MaterialType::Mix => Self::Mix(mix(node)?),
                })
            }

            /// The table as what all surfaces have in common; or the mix.
            pub(crate) fn surface(&self) -> std::result::Result<&dyn SurfaceTable, &MixTable> {
                match self {
                    $(Self::$kind(table) => Ok(table),)*
                    Self::Mix(table) => Err(table),
                }
            }
        }
    };
}

material_types! {
    /// Diffuse: Lambert's law.
    Diffuse(DiffuseTable),
    /// Bare metal.
    Conductor(ConductorTable),
    /// Clear glass or liquid.
    Dielectric(DielectricTable),
    /// The model of glTF: painted, plastic or metal.
    MetallicRoughness(MetallicRoughnessTable),
    /// Diffuse with relief, as plaster and clay: the model of Oren and Nayar.
    OrenNayar(OrenNayarTable),
    /// A coloured body under a clear surface.
    Plastic(PlasticTable),
    /// A polished pane.
    ThinDielectric(ThinDielectricTable),
    /// A thin diffuse sheet that lets light through: paper, a leaf.
    Translucent(TranslucentTable),
    /// The model of Phong.
    Phong(PhongTable),
    /// Retroreflective sheeting, as of road signs and of markers for motion capture.
    Retroreflective(RetroreflectiveTable),
}

/// Keys that any surface may have beside its model.
#[derive(Clone, Copy, Default)]
pub(crate) struct SurfaceKeys<'a> {
    pub(crate) emission: Option<&'a EmissionTable>,
    pub(crate) normal_map: Option<&'a TextureFile>,
    pub(crate) double_sided: Option<bool>,
}

/// A table with the keys that any surface may have.
pub(crate) trait CommonKeys {
    /// Their values.
    fn common(&self) -> SurfaceKeys<'_>;
}

/// A table that describes a model.
pub(crate) trait SurfaceTable: CommonKeys {
    /// Model of distortion.
    fn model(&self, finder: &mut Finder<'_>) -> std::result::Result<MaterialModel, Invalid>;
}

/// A table with the keys that any surface may have, after its own.
macro_rules! surface_table {
    (
        $(#[$attribute:meta])*
        $table:ident { $($(#[$field_attribute:meta])* $field:ident: $type:ty,)* }
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Deserialize, JsonSchema, Keys)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $table {
            $($(#[$field_attribute])* pub(crate) $field: $type,)*
            /// Light that the surface gives.
            pub(crate) emission: Option<EmissionTable>,
            /// A normal map (glTF convention).
            pub(crate) normal_map: Option<TextureFile>,
            /// Whether the back scatters and shines like the front. Left out: as in the geometry's file.
            pub(crate) double_sided: Option<bool>,
        }

        impl CommonKeys for $table {
            fn common(&self) -> SurfaceKeys<'_> {
                SurfaceKeys {
                    emission: self.emission.as_ref(),
                    normal_map: self.normal_map.as_ref(),
                    double_sided: self.double_sided,
                }
            }
        }
    };
}

/// The geometry's own material with changes.
#[derive(Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct KeptTable {
    /// Colour, in place of that or of the texture of the geometry's file. Left out: that of the file.
    pub(crate) base_colour: Option<ReflectanceSource>,
    /// Roughness, 0–1, in place of that or of the texture of the geometry's file. Left out: that of the file.
    #[schemars(transform = within(0.0..=1.0))]
    pub(crate) roughness: Option<f64>,
    /// Whether it is metal, 0–1, likewise. Left out: as in the file.
    #[schemars(transform = within(0.0..=1.0))]
    pub(crate) metallic: Option<f64>,
    /// Whether light goes on that bounces more than once between the microfacets of rough glass. Left out: no.
    pub(crate) energy_compensation: Option<bool>,
    /// Light that the surface gives. Left out: that of the file.
    pub(crate) emission: Option<EmissionTable>,
    /// Whether the back scatters and shines like the front. Left out: as in the file.
    pub(crate) double_sided: Option<bool>,
}

surface_table! {
    /// Diffuse: Lambert's law.
    DiffuseTable {
        /// The part of the light that it reflects.
        reflectance: ReflectanceSource,
    }
}

surface_table! {
    /// Bare metal.
    ConductorTable {
        /// Metal: "Au", "Ag", "Cu", "Al", { file = "n-k.csv" } with columns n and k, or { eta = …, k = … }.
        metal: MetalSource,
        /// 0 is polished, 1 is matt; microfacets have α = roughness². Left out: 0.
        #[schemars(transform = within(0.0..=1.0))]
        roughness: Option<f64>,
        /// −1 to 1: roughness along the tangent (positive) or across it. Left out: 0.
        #[schemars(transform = within(-1.0..=1.0))]
        anisotropy: Option<f64>,
        /// Whether light comes back that bounces more than once between microfacets, as it does from glTF's metals.
        /// Left out: no, as in other renderers, which lose it.
        energy_compensation: Option<bool>,
    }
}

/// A metal: its name or symbol, { file = "n-k.csv" } with columns n and k, or { eta = …, k = … }.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected the name of a metal, { file = \"n-k.csv\" } or { eta = …, k = … }")]
pub(crate) enum MetalSource {
    /// A metal that ships with photosite.
    Name(String),
    /// A CSV file of wavelengths in nm and columns n and k.
    #[keys(given = "photosite_sensor::keys::CurveKeys")]
    File(CurveFile),
    /// The parts of the complex refractive index n + ik one by one.
    Parts(IndexParts),
}

/// A complex refractive index.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct IndexParts {
    /// Real part n.
    pub(crate) eta: SpectrumSource,
    /// Imaginary part k.
    pub(crate) k: SpectrumSource,
}

/// Clear glass or liquid.
#[derive(Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct DielectricTable {
    /// Name of a medium that ships with photosite: "BK7", "SF11", "fused-silica", "water" … Or give its index.
    pub(crate) glass: Option<String>,
    /// Refractive index of the side that normals point away from, relative to the other.
    pub(crate) index: Option<IndexSource>,
    /// Abbe number, with an index that is a number: how little the index depends on wavelength. Left out: not at all.
    #[schemars(transform = above(0.0..))]
    pub(crate) abbe_number: Option<f64>,
    /// 0 is polished, 1 is ground; microfacets have α = roughness². Left out: 0.
    #[schemars(transform = within(0.0..=1.0))]
    pub(crate) roughness: Option<f64>,
    /// Whether light goes on that bounces more than once between microfacets. Left out: no, as in other renderers,
    /// which lose it.
    pub(crate) energy_compensation: Option<bool>,
}

impl CommonKeys for DielectricTable {
    fn common(&self) -> SurfaceKeys<'_> {
        SurfaceKeys::default()
    }
}

/// A refractive index: a number (at 587.6 nm), { sellmeier_b = […], sellmeier_c_um2 = […] },
/// { cauchy_a = …, cauchy_b_um2 = … } or { file = "n.csv" }.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(
    untagged,
    expecting = "expected a number, { sellmeier_b = […], sellmeier_c_um2 = […] }, { cauchy_a = …, cauchy_b_um2 = … } or { file = \"n.csv\" }"
)]
pub(crate) enum IndexSource {
    /// At the d line, 587.6 nm.
    Number(#[schemars(transform = above(0.0..))] f64),
    /// n² = 1 + Σ Bᵢλ²/(λ² − Cᵢ), λ in µm.
    Sellmeier(SellmeierTable),
    /// n = A + B/λ² + C/λ⁴, λ in µm.
    Cauchy(CauchyTable),
    /// A CSV file of wavelengths in nm and indices.
    #[keys(given = "photosite_sensor::keys::CurveKeys")]
    File(CurveFile),
}

/// n² = 1 + Σ Bᵢλ²/(λ² − Cᵢ), λ in µm.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct SellmeierTable {
    /// The Bᵢ.
    pub(crate) sellmeier_b: Vec<f64>,
    /// The Cᵢ, µm².
    pub(crate) sellmeier_c_um2: Vec<f64>,
}

/// n = A + B/λ² + C/λ⁴, λ in µm.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct CauchyTable {
    /// A.
    pub(crate) cauchy_a: f64,
    /// B, µm².
    pub(crate) cauchy_b_um2: f64,
    /// C, µm⁴. Left out: 0.
    #[serde(default)]
    pub(crate) cauchy_c_um4: f64,
}

surface_table! {
    /// The model of glTF: painted, plastic or metal.
    MetallicRoughnessTable {
        /// Colour: of the diffuse reflection where it is no metal, of the mirroring where it is.
        base_colour: ReflectanceSource,
        /// 0 is no metal, 1 is metal. Left out: 0.
        #[schemars(transform = within(0.0..=1.0))]
        metallic: Option<f64>,
        /// 0 is polished, 1 is matt; microfacets have α = roughness².
        #[schemars(transform = within(0.0..=1.0))]
        roughness: f64,
        /// An image whose green scales the roughness and whose blue scales the metalness.
        metallic_roughness_map: Option<TextureFile>,
    }
}

surface_table! {
    /// Diffuse with relief, as plaster and clay: the model of Oren and Nayar.
    OrenNayarTable {
        /// The part of the light that it reflects.
        reflectance: ReflectanceSource,
        /// 0 is smooth (Lambert's law), 1 as rough as it gets.
        #[schemars(transform = within(0.0..=1.0))]
        roughness: f64,
    }
}

surface_table! {
    /// A coloured body under a clear surface.
    PlasticTable {
        /// The part of the light that gets in that comes out again.
        reflectance: ReflectanceSource,
        /// Name of a medium that ships with photosite. Or give its index.
        glass: Option<String>,
        /// Refractive index. Left out, as the glass: 1.5.
        index: Option<IndexSource>,
        /// 0 is polished, 1 is matt; microfacets have α = roughness². Left out: 0.
        #[schemars(transform = within(0.0..=1.0))]
        roughness: Option<f64>,
    }
}

/// A polished pane: both its surfaces in one.
#[derive(Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct ThinDielectricTable {
    /// Name of a medium that ships with photosite: "BK7", "water" … Or give its index.
    pub(crate) glass: Option<String>,
    /// Refractive index.
    pub(crate) index: Option<IndexSource>,
    /// Abbe number, with an index that is a number. Left out: the index is the same at all wavelengths.
    #[schemars(transform = above(0.0..))]
    pub(crate) abbe_number: Option<f64>,
    /// Internal transmittance along the normal, without what the surfaces reflect: a number, a name or a CSV file.
    /// Left out: 1.
    pub(crate) transmittance: Option<SpectrumSource>,
}

impl CommonKeys for ThinDielectricTable {
    fn common(&self) -> SurfaceKeys<'_> {
        SurfaceKeys::default()
    }
}

surface_table! {
    /// A thin diffuse sheet that lets light through: paper, a leaf.
    TranslucentTable {
        /// The part of the light that it reflects.
        reflectance: ReflectanceSource,
        /// The part of the light that it lets through. With the other at most 1 at any wavelength.
        transmittance: ReflectanceSource,
    }
}

surface_table! {
    /// The model of Phong, in the form that conserves energy: diffuse/π + specular·(n + 2)/(2π)·cosⁿα.
    PhongTable {
        /// The part of the light that is scattered by Lambert's law.
        diffuse: ReflectanceSource,
        /// The part of the light that goes into the lobe. With the other at most 1 at any wavelength.
        specular: ReflectanceSource,
        /// n, 0 to 100 000.
        #[schemars(transform = within(0.0..=1e5))]
        exponent: f64,
    }
}

surface_table! {
    /// Retroreflective sheeting, as of road signs and of markers for motion capture: cube corners below a clear surface
    /// send light back to where it comes from.
    RetroreflectiveTable {
        /// The part of the light along the normal that goes back. From aslant it is less: corners pass on what they do
        /// not hold, and nothing goes back where light is steeper than 35.3° within the sheeting.
        retroreflectance: ReflectanceSource,
        /// The part of all other light that is scattered by Lambert's law.
        reflectance: ReflectanceSource,
        /// How wide the lobe is about the direction back: microfacets have α = roughness², and luminance has fallen to
        /// half at an observation angle of 1.29·α rad. Left out: 0.1, which is 0.74°.
        #[schemars(transform = within(0.0..=1.0))]
        roughness: Option<f64>,
        /// Refractive index of the sheeting, at least 1. Left out: that of polycarbonate, 1.586.
        #[schemars(transform = within(1.0..=4.0))]
        index: Option<f64>,
    }
}

/// Two materials side by side, finer than the eye sees.
#[derive(Debug, JsonSchema, Keys)]
#[schemars(deny_unknown_fields)]
pub(crate) struct MixTable {
    /// One of them, without light or normal map of its own.
    pub(crate) first: Box<TypedMaterialTable>,
    /// The other.
    pub(crate) second: Box<TypedMaterialTable>,
    /// How it is mixed.
    #[schemars(flatten)]
    pub(crate) rest: MixRest,
}

surface_table! {
    /// Keys of a mix beside those of both its materials.
    MixRest {
        /// The part of the surface that the second covers, 0–1.
        #[schemars(transform = within(0.0..=1.0))]
        weight: f64,
    }
}

/// Light that a surface gives, the same in all directions. Its colour: illuminant, spectrum, rgb or linear_rgb.
#[derive(Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct EmissionTable {
    /// Name of an illuminant: "D65", "A", "F11", "LED-B3", "3000K" (a blackbody) … Left out, as are the other colours:
    /// "D65".
    pub(crate) illuminant: Option<String>,
    /// A spectrum: the name of one that ships with photosite such as "cornell/light", { file = "lamp.csv" }, or a
    /// number for equal energy.
    pub(crate) spectrum: Option<SpectrumSource>,
    /// sRGB as displayed, 0–1 each.
    #[schemars(transform = within(0.0..=1.0))]
    pub(crate) rgb: Option<[f64; 3]>,
    /// Linear sRGB.
    #[schemars(transform = within(0.0..))]
    pub(crate) linear_rgb: Option<[f64; 3]>,
    /// Luminance, nit. May be left out for a blackbody, and for a spectrum from a file: then that is the radiance in
    /// W·m⁻²·sr⁻¹·nm⁻¹.
    #[schemars(transform = within(0.0..))]
    pub(crate) luminance_nit: Option<f64>,
    /// An image that scales it.
    pub(crate) texture: Option<TextureFile>,
}

impl EmissionTable {
    /// The keys that say what colour it has.
    pub(crate) fn colour(&self) -> LightColour<'_> {
        LightColour {
            illuminant: self.illuminant.as_deref(),
            spectrum: self.spectrum.as_ref(),
            rgb: self.rgb,
            linear_rgb: self.linear_rgb,
        }
    }
}
