//! Colours of surfaces and lights.

use schemars::JsonSchema;
use serde::Deserialize;

use photosite_core::keys::Keys;
use photosite_core::schema_range::within;
use photosite_sensor::{CurveFile, SpectrumSource};
use photosite_transport::texture::{Filter, Wrap};

/// Reflectance of a surface: a number 0–1, an sRGB triple as displayed such as [0.8, 0.2, 0.1], the
/// name of a reflectance that ships with photosite such as "colour-checker/15-red", { file = "red.csv" },
/// { linear_rgb = [0.6, 0.03, 0.01] } or { texture = "wood.png" }.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(
    untagged,
    expecting = "expected a number from 0 to 1, three of them, the name of a reflectance, { file = \"red.csv\" }, { linear_rgb = [0.6, 0.03, 0.01] } or { texture = \"wood.png\" }"
)]
pub(crate) enum ReflectanceSource {
    /// The same at every wavelength.
    Number(#[schemars(transform = within(0.0..=1.0))] f64),
    /// sRGB as displayed.
    Rgb(#[schemars(transform = within(0.0..=1.0))] [f64; 3]),
    /// A reflectance that ships with photosite.
    Name(String),
    /// A CSV file of wavelengths in nm and reflectances.
    #[keys(given = "photosite_sensor::keys::CurveKeys")]
    File(CurveFile),
    /// Linear sRGB.
    Linear(LinearRgb),
    /// An image.
    Texture(TextureFile),
}

/// Linear sRGB.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct LinearRgb {
    /// Red, green, blue, 0–1 each.
    #[schemars(transform = within(0.0..=1.0))]
    pub(crate) linear_rgb: [f64; 3],
}

/// An image on a surface, by its first UV set.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct TextureFile {
    /// A PNG, JPEG, OpenEXR or Radiance HDR file, relative to this file.
    pub(crate) texture: String,
    /// How often the image fits into the unit square along u and v. Left out: [1, 1].
    pub(crate) tiles: Option<[f64; 2]>,
    /// Filter: the interpolation between texels. Left out: "linear".
    pub(crate) filter: Option<Filter>,
    /// Wrap mode: the continuation of the image beyond its borders. Left out: "repeat".
    pub(crate) wrap: Option<Wrap>,
}

/// The keys of a table that say what colour a light has; one of them at most may be there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightColour<'a> {
    pub(crate) illuminant: Option<&'a str>,
    pub(crate) spectrum: Option<&'a SpectrumSource>,
    pub(crate) rgb: Option<[f64; 3]>,
    pub(crate) linear_rgb: Option<[f64; 3]>,
}
