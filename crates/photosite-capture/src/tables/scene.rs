//! `[scene]`.

use schemars::JsonSchema;
use serde::Deserialize;

use photosite_sensor::SpectrumSource;

use super::surroundings::{BackdropTable, GroundSource};
use super::{LightColour, ObjectTable, UpAxis};
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_scene_io::MissingNormals;

/// Geometry and surroundings.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneTable {
    /// Files of geometry, glTF (.gltf, .glb), OBJ (.obj), PLY (.ply) or STL (.stl), relative to this file, in the
    /// coordinates that they state; `[[scene.objects]]` places files by poses.
    #[serde(default)]
    pub(crate) geometry: Vec<String>,
    /// Name of a material variant of the glTF files (KHR_materials_variants). Left out: their basic materials.
    pub(crate) variant: Option<String>,
    /// Name of an animation of the glTF files, or "animation-0" … for those without a name. Left out: the static poses
    /// of the files.
    pub(crate) animation: Option<String>,
    /// Time of the animation at scene.time_s = 0, s. Left out: 0.
    pub(crate) animation_time_s: Option<f64>,
    /// Start of the first exposure, s, on the clock of animations and of objects that move. Left out: 0; along the
    /// trajectory of a data set, the time of the frame.
    pub(crate) time_s: Option<f64>,
    /// Length of the unit of OBJ, PLY and STL files, which state none, m. Left out: 1, with a warning where such a
    /// scene is longer than 20 units, as most of these are in millimetres. (glTF is in metres.)
    #[schemars(transform = above(0.0..))]
    pub(crate) meters_per_unit: Option<f64>,
    /// Axis that points up in the files of `geometry`; it is turned to y. Left out: "z" of STL files, which come from
    /// CAD, with a warning, and "y" of others.
    pub(crate) up: Option<UpAxis>,
    /// Shading of faces without normals in OBJ, PLY and STL files, outside the smoothing groups of OBJ. Left out:
    /// "flat".
    pub(crate) generate_normals: Option<MissingNormals>,
    /// Whether grey takes the place of a texture of these files that is missing or broken, with a warning. Left out:
    /// false: such a texture is an error.
    #[serde(default)]
    pub(crate) lenient: bool,
    /// Objects: files of geometry with poses of their own.
    #[serde(default)]
    pub(crate) objects: Vec<ObjectTable>,
    /// Spheres, besides the geometry of the files.
    #[serde(default)]
    pub(crate) spheres: Vec<SphereTable>,
    /// Disks, besides the geometry of the files.
    #[serde(default)]
    pub(crate) disks: Vec<DiskTable>,
    /// Cylinders, besides the geometry of the files.
    #[serde(default)]
    pub(crate) cylinders: Vec<CylinderTable>,
    /// Environment light, from infinitely far in all directions. Left out: none. (A scene file that is given in place
    /// of a capture gets a sky, unless it has lights of its own.)
    pub(crate) environment: Option<EnvironmentSource>,
    /// Level ground under everything, out to the horizon: true, or a table of its keys. Left out: none. (A scene file
    /// that is given in place of a capture has one together with its sky.)
    pub(crate) ground: Option<GroundSource>,
    /// Studio backdrop: a floor that curves up into a wall behind the geometry. Left out: none.
    pub(crate) backdrop: Option<BackdropTable>,
}

impl SceneTable {
    /// Key of the first thing that moves; `None` without any.
    pub(crate) fn mover(&self) -> Option<String> {
        let of_object = |(i, object): (usize, &ObjectTable)| match (&object.motion, &object.animation) {
            (Some(_), _) => Some(format!("scene.objects[{i}].motion")),
            (None, Some(_)) => Some(format!("scene.objects[{i}].animation")),
            (None, None) => None,
        };
        let of_scene = self.animation.as_ref().map(|_| "scene.animation".to_owned());
        of_scene.or_else(|| self.objects.iter().enumerate().find_map(of_object))
    }
}

/// Sphere, exact, without the facets of one made of triangles. It shines outwards where its material has an emission,
/// and inwards too where that is `double_sided`.
#[derive(Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct SphereTable {
    /// Name, for messages and lists of instances. Left out: "sphere-0" …
    pub(crate) name: Option<String>,
    /// Name of its material, of `[materials]` or of the geometry's files.
    pub(crate) material: String,
    /// Centre, m.
    pub(crate) position_m: [f64; 3],
    /// Radius, m.
    #[schemars(transform = within(1e-15..))]
    pub(crate) radius_m: f64,
}

/// Disk, exact, without the corners of one made of triangles. It shines to its front where its material has an emission,
/// and to both sides where that is `double_sided`.
#[derive(Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct DiskTable {
    /// Name, for messages and lists of instances. Left out: "disk-0" …
    pub(crate) name: Option<String>,
    /// Name of its material, of `[materials]` or of the geometry's files.
    pub(crate) material: String,
    /// Centre, m.
    pub(crate) position_m: [f64; 3],
    /// Direction of the normal of its front, of any length.
    pub(crate) normal: [f64; 3],
    /// Radius, m.
    #[schemars(transform = within(1e-15..))]
    pub(crate) radius_m: f64,
}

/// Cylinder without caps, exact, without the facets of one made of triangles; disks can close it. It shines outwards
/// where its material has an emission, and inwards too where that is `double_sided`.
#[derive(Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct CylinderTable {
    /// Name, for messages and lists of instances. Left out: "cylinder-0" …
    pub(crate) name: Option<String>,
    /// Name of its material, of `[materials]` or of the geometry's files.
    pub(crate) material: String,
    /// Middle of the axis, m.
    pub(crate) position_m: [f64; 3],
    /// Direction of the axis, of any length.
    pub(crate) axis: [f64; 3],
    /// Radius, m.
    #[schemars(transform = within(1e-15..))]
    pub(crate) radius_m: f64,
    /// Length, the distance between both ends, m.
    #[schemars(transform = within(1e-15..))]
    pub(crate) length_m: f64,
}

/// Environment light, from infinitely far: "none"; "even", the same light everywhere as in a bright room, D65 of 500
/// lux; or a table.
#[derive(Debug, JsonSchema, Keys)]
#[schemars(untagged)]
pub(crate) enum EnvironmentSource {
    /// "none" or "even".
    Name(#[schemars(extend("enum" = ["none", "even"]))] String),
    /// The same light everywhere, a sky, or an image.
    Table(Box<EnvironmentTable>),
}

impl<'de> Deserialize<'de> for EnvironmentSource {
    /// Unlike a derived one it keeps the places of what is wrong within the table.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = EnvironmentSource;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("\"none\", \"even\" or a table such as { illuminant = \"D65\", illuminance_lux = 500 }")
            }

            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Self::Value, E> {
                Ok(EnvironmentSource::Name(name.to_owned()))
            }

            fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                let deserializer = serde::de::value::MapAccessDeserializer::new(map);
                EnvironmentTable::deserialize(deserializer).map(|table| EnvironmentSource::Table(Box::new(table)))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// Environment light, from infinitely far: the same everywhere (illuminant, spectrum, rgb or linear_rgb), or an image.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct EnvironmentTable {
    /// Name of an illuminant: "D65", "A", "F11", "LED-B3", "3000K" (a blackbody) …
    pub(crate) illuminant: Option<String>,
    /// Spectrum: the name of one that ships with photosite, { file = "lamp.csv" }, or a number for equal energy.
    pub(crate) spectrum: Option<SpectrumSource>,
    /// sRGB as displayed, 0–1 each.
    #[schemars(transform = within(0.0..=1.0))]
    pub(crate) rgb: Option<[f64; 3]>,
    /// Linear sRGB.
    #[schemars(transform = within(0.0..))]
    pub(crate) linear_rgb: Option<[f64; 3]>,
    /// Sky of a clear or hazy day with the sun, in absolute units.
    pub(crate) sky: Option<SkyTable>,
    /// Equirectangular image, Radiance HDR or OpenEXR, relative to this file.
    pub(crate) image: Option<String>,
    /// Turn of the image about the vertical axis, counter-clockwise seen from above, degrees. Left out: 0.
    pub(crate) rotation_deg: Option<f64>,
    /// Illuminance on a horizontal plane facing up, lux.
    #[schemars(transform = within(0.0..))]
    pub(crate) illuminance_lux: Option<f64>,
    /// Luminance, nit; instead of illuminance_lux. It is refused for images.
    #[schemars(transform = within(0.0..))]
    pub(crate) luminance_nit: Option<f64>,
    /// Luminance of a white pixel of value 1, nit; instead of illuminance_lux. It applies to images only.
    #[schemars(transform = above(0.0..))]
    pub(crate) nit_per_unit: Option<f64>,
}

/// Sky by Hosek and Wilkie's model. North is −Z, east +X.
#[derive(Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct SkyTable {
    /// Height of the sun above the horizon, degrees, 0–90; or give date_time.
    #[schemars(transform = within(0.0..=90.0))]
    pub(crate) sun_elevation_deg: Option<f64>,
    /// Azimuth of the sun, degrees from north over east. Left out, as is date_time: 0.
    pub(crate) sun_azimuth_deg: Option<f64>,
    /// Date and time with the offset from Universal Time, 2026-06-21T12:00:00+02:00, from which the place of the sun
    /// follows; years 1950 to 2050.
    pub(crate) date_time: Option<String>,
    /// Latitude, with date_time, degrees north of the equator.
    #[schemars(transform = within(-90.0..=90.0))]
    pub(crate) latitude_deg: Option<f64>,
    /// Longitude, with date_time, degrees east of Greenwich.
    #[schemars(transform = within(-180.0..=180.0))]
    pub(crate) longitude_deg: Option<f64>,
    /// Turbidity, the haze: 2 is very clear, 3 clear, 6 warm and moist, 10 hazy; 1–10. Left out: 3.
    #[schemars(transform = within(1.0..=10.0))]
    pub(crate) turbidity: Option<f64>,
    /// Reflectance of the ground, 0–1, which the sky is lit by, and which is seen below the horizon: a matt plane at
    /// infinity in the light of sky and sun. Left out: 0.2.
    #[schemars(transform = within(0.0..=1.0))]
    pub(crate) ground_albedo: Option<f64>,
    /// Whether the sky has the sun's disk. Left out: true.
    pub(crate) sun: Option<bool>,
}

impl EnvironmentTable {
    /// The keys that mean nothing beside a sky, and whether they are given.
    pub(crate) fn beside_sky(&self) -> [(&'static str, bool); 9] {
        [
            ("illuminant", self.illuminant.is_some()),
            ("spectrum", self.spectrum.is_some()),
            ("rgb", self.rgb.is_some()),
            ("linear_rgb", self.linear_rgb.is_some()),
            ("image", self.image.is_some()),
            ("rotation_deg", self.rotation_deg.is_some()),
            ("illuminance_lux", self.illuminance_lux.is_some()),
            ("luminance_nit", self.luminance_nit.is_some()),
            ("nit_per_unit", self.nit_per_unit.is_some()),
        ]
    }

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
