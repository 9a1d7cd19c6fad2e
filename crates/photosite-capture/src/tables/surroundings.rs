//! `[scene.ground]` and `[scene.backdrop]`.

use schemars::JsonSchema;
use serde::Deserialize;

use super::ReflectanceSource;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

/// Level ground, or whether there is one.
#[derive(Debug, JsonSchema, Keys)]
#[schemars(untagged)]
pub(crate) enum GroundSource {
    /// Whether there is a ground, with the defaults of its keys.
    Flag(bool),
    /// A ground with these keys.
    Table(Box<GroundTable>),
}

impl<'de> Deserialize<'de> for GroundSource {
    /// Unlike a derived one it keeps the places of what is wrong within the table.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = GroundSource;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("true, false or a table such as { height_m = 0.0, reflectance = 0.3 }")
            }

            fn visit_bool<E: serde::de::Error>(self, is_there: bool) -> Result<Self::Value, E> {
                Ok(GroundSource::Flag(is_there))
            }

            fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                let deserializer = serde::de::value::MapAccessDeserializer::new(map);
                GroundTable::deserialize(deserializer).map(|table| GroundSource::Table(Box::new(table)))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// Level ground under everything. It is lit as all surfaces are, catches shadows, hides what is below the horizon, and
/// is called "ground" in lists of instances. The size of the scene, by which a camera is placed and the spectrum of the
/// light is weighed, is that without it.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct GroundTable {
    /// Height of the ground, m. Left out: a little below the lowest point of the geometry, by less than 1/5000 of the
    /// radius of all of it, so that it lies in no face of the geometry.
    #[schemars(transform = within(-1e18..=1e18))]
    pub height_m: Option<f64>,
    /// Reflectance, as of `type = "diffuse"`. Left out, as is material: the ground_albedo of the
    /// sky, or 0.2.
    pub reflectance: Option<ReflectanceSource>,
    /// Name of its material in place of reflectance, of `[materials]` or of the geometry's files. Textures repeat after
    /// a metre.
    pub material: Option<String>,
    /// Length of its sides, m, about the middle of the geometry. Left out: two million times the radius of the
    /// geometry, so that from a height of ten times that radius the strip between its rim and the horizon is seen under
    /// an angle of 10 µrad, far less than a pixel.
    #[schemars(transform = within(1e-15..=1e18))]
    pub size_m: Option<f64>,
}

/// Studio backdrop: a level floor that curves up into a wall behind the geometry. It is called "backdrop" in lists of
/// instances, and no part of the size of the scene, as a ground. Lengths that are left out are in proportion to the
/// radius of the geometry.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct BackdropTable {
    /// Height of the floor, m. Left out: a little below the lowest point of the geometry, as that of a ground.
    #[schemars(transform = within(-1e18..=1e18))]
    pub height_m: Option<f64>,
    /// Reflectance, as of `type = "diffuse"`. Left out, as is material: 0.5.
    pub reflectance: Option<ReflectanceSource>,
    /// Name of its material in place of reflectance, of `[materials]` or of the geometry's files. Textures repeat after
    /// a metre.
    pub material: Option<String>,
    /// Turn about the vertical axis through the middle of the geometry, degrees, counter-clockwise seen from above.
    /// Left out: 0, with the wall in the direction of −Z, behind models that face +Z.
    pub rotation_deg: Option<f64>,
    /// Distance of the wall from the middle of the geometry, m. Left out: 4 radii.
    #[schemars(transform = within(1e-15..=1e18))]
    pub distance_m: Option<f64>,
    /// Radius of the curve between floor and wall, m, at most that distance. Left out: half of it.
    #[schemars(transform = within(1e-15..=1e18))]
    pub curve_radius_m: Option<f64>,
    /// Width, m; the floor reaches five times as far to the front. Left out: 40 radii.
    #[schemars(transform = within(1e-15..=1e18))]
    pub width_m: Option<f64>,
    /// Height of the wall above the floor, m, at least the radius of the curve. Left out: 10 radii.
    #[schemars(transform = within(1e-15..=1e18))]
    pub wall_height_m: Option<f64>,
}
