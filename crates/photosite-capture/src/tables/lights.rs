//! `[[lights]]`.

use schemars::JsonSchema;
use serde::Deserialize;

use super::super::tree::nodes::Node;
use super::super::tree::source::CaptureSource;
use super::LightColour;
use photosite_core::Result;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_sensor::SpectrumSource;

/// Declares the tables of all lights, by their names in `type`.
macro_rules! light_types {
    ($($(#[$doc:meta])* $kind:ident($table:ident) = $name:literal,)*) => {
        /// A light without a surface.
        #[derive(Debug, JsonSchema, Keys)]
        #[schemars(tag = "type")]
        pub(crate) enum LightTable {
            $($(#[$doc])* #[schemars(rename = $name)] $kind($table),)*
        }

        /// The value of `type`.
        #[derive(Clone, Copy, Debug, Deserialize)]
        pub(crate) enum LightType {
            $(#[serde(rename = $name)] $kind,)*
        }

        impl LightType {
            /// The values that there are.
            pub(crate) const NAMES: &[&str] = &[$($name,)*];
        }

        impl LightTable {
            /// Reads a table of a type.
            pub(crate) fn read(kind: LightType, source: &CaptureSource, path: &str, node: &Node) -> Result<Self> {
                Ok(match kind {
                    $(LightType::$kind => Self::$kind(source.read_node(path, node)?),)*
                })
            }

            /// Name of the light, for messages.
            pub(crate) fn name(&self) -> Option<&str> {
                match self {
                    $(Self::$kind(table) => table.name.as_deref(),)*
                }
            }

            /// Whether the light shines.
            pub(crate) fn is_on(&self) -> bool {
                match self {
                    $(Self::$kind(table) => table.on.unwrap_or(true),)*
                }
            }
        }
    };
}

light_types! {
    /// Point light with the same intensity in all directions.
    Point(PointTable) = "point",
    /// Spot light, intensity within a cone.
    Spot(SpotTable) = "spot",
    /// Light from infinitely far in one direction, as from the sun.
    Directional(DirectionalTable) = "directional",
    /// Lamp whose intensity was measured in many directions: an IES file.
    Profile(ProfileTable) = "profile",
    /// Projector, a slide that a lens throws.
    Projector(ProjectorTable) = "projector",
    /// Laser beam, or one that a lens spreads to a line.
    GaussianBeam(GaussianBeamTable) = "gaussian-beam",
}

/// Declares a light's table: the keys that all have, and its own.
macro_rules! light_table {
    ($(#[$attribute:meta])* $name:ident { $($(#[$of_key:meta])* $key:ident: $kind:ty,)* }) => {
        $(#[$attribute])*
        #[derive(Debug, Deserialize, JsonSchema, Keys)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $name {
            /// Name, for messages and to change its keys by: `--set lights.NAME.on=false`.
            pub(crate) name: Option<String>,
            /// Whether the light shines. Left out: true.
            pub(crate) on: Option<bool>,
            $($(#[$of_key])* pub(crate) $key: $kind,)*
            /// Name of an illuminant: "D65", "A", "F11", "LED-B3", "3000K" (a blackbody) … Left out, as are the other
            /// colours: "D65".
            pub(crate) illuminant: Option<String>,
            /// A spectrum: the name of one that ships with photosite, { file = "lamp.csv" }, or a number for equal
            /// energy.
            pub(crate) spectrum: Option<SpectrumSource>,
            /// sRGB as displayed, 0–1 each.
            #[schemars(transform = within(0.0..=1.0))]
            pub(crate) rgb: Option<[f64; 3]>,
            /// Linear sRGB.
            #[schemars(transform = within(0.0..))]
            pub(crate) linear_rgb: Option<[f64; 3]>,
        }

        impl $name {
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
    };
}

light_table! {
    /// Point light with the same intensity in all directions.
    PointTable {
        /// Position, m.
        position_m: [f64; 3],
        /// Luminous intensity, cd.
        #[schemars(transform = within(0.0..))]
        intensity_cd: f64,
    }
}

light_table! {
    /// Spot light, intensity within a cone, falling off smoothly between two angles.
    SpotTable {
        /// Position, m.
        position_m: [f64; 3],
        /// Point that the light shines at, m; or give its direction.
        look_at_m: Option<[f64; 3]>,
        /// Direction that the light shines in, of any length; or give look_at_m.
        direction: Option<[f64; 3]>,
        /// Luminous intensity on its axis, cd.
        #[schemars(transform = within(0.0..))]
        intensity_cd: f64,
        /// Angle from the axis up to which the intensity is full, degrees. Left out: 0.
        #[schemars(transform = within(0.0..90.0))]
        inner_angle_deg: Option<f64>,
        /// Angle from the axis beyond which there is no light, degrees, at most 90.
        #[schemars(transform = above(0.0..=90.0))]
        outer_angle_deg: f64,
    }
}

light_table! {
    /// Light from infinitely far in one direction, as from the sun.
    DirectionalTable {
        /// Direction that the light shines in, of any length: [0, -1, 0] is from above.
        direction: [f64; 3],
        /// Illuminance on a plane across the direction, lux.
        #[schemars(transform = within(0.0..))]
        illuminance_lux: f64,
    }
}

light_table! {
    /// Lamp whose intensity was measured in many directions.
    ProfileTable {
        /// IES file (LM-63), relative to this one. Its vertical angle 0 is the direction that the lamp shines in.
        file: String,
        /// Position, m; or give gltf_light.
        position_m: Option<[f64; 3]>,
        /// Name of a light of the geometry whose place this light takes.
        gltf_light: Option<String>,
        /// Point that the light shines at, m; or give its direction.
        look_at_m: Option<[f64; 3]>,
        /// Direction that the light shines in, of any length; or give look_at_m. Left out, as is look_at_m: down, or
        /// that of gltf_light.
        direction: Option<[f64; 3]>,
        /// Turn about that direction, degrees, clockwise seen from behind the lamp. Left out: 0.
        rotation_deg: Option<f64>,
        /// Luminous flux, lm, in place of that of the file.
        #[schemars(transform = within(0.0..))]
        flux_lm: Option<f64>,
    }
}

light_table! {
    /// Projector, a slide that a lens throws.
    ProjectorTable {
        /// Slide: PNG, JPEG or WebP, sRGB, or OpenEXR or Radiance HDR, relative to this file.
        image: String,
        /// Centre of the lens, m; or give gltf_camera.
        position_m: Option<[f64; 3]>,
        /// Point on the optical axis, m.
        look_at_m: Option<[f64; 3]>,
        /// Direction that is up in the image. Left out: [0, 1, 0].
        up: Option<[f64; 3]>,
        /// Name of a camera of the geometry whose place and field of view the projector takes.
        gltf_camera: Option<String>,
        /// Angle over the width of the projected image, degrees; or give focal_length_px.
        #[schemars(transform = above(0.0..180.0))]
        horizontal_fov_deg: Option<f64>,
        /// Focal lengths fx and fy in pixels of the slide.
        #[schemars(transform = above(0.0..))]
        focal_length_px: Option<[f64; 2]>,
        /// Principal point cx and cy from the top-left corner of the slide. Left out: its middle.
        principal_point_px: Option<[f64; 2]>,
        /// Diameter of the aperture, mm. Left out: 0, sharp everywhere.
        #[schemars(transform = within(0.0..))]
        aperture_mm: Option<f64>,
        /// Distance of the plane of focus, m; needed with aperture_mm.
        #[schemars(transform = above(0.0..))]
        focus_distance_m: Option<f64>,
        /// Luminous flux with a white slide, lm; or give power_w.
        #[schemars(transform = within(0.0..))]
        flux_lm: Option<f64>,
        /// Radiant flux with a white slide, W, for instance of an infrared projector; or give flux_lm.
        #[schemars(transform = within(0.0..))]
        power_w: Option<f64>,
    }
}

light_table! {
    /// Laser beam, or one that a lens spreads to a line: irradiance across it that falls as a Gaussian function.
    GaussianBeamTable {
        /// Start of the beam, m.
        position_m: [f64; 3],
        /// Point that the light shines at, m; or give its direction.
        look_at_m: Option<[f64; 3]>,
        /// Direction that the light shines in, of any length; or give look_at_m.
        direction: Option<[f64; 3]>,
        /// Turn about that direction, degrees, clockwise seen along the beam. At 0 its second axis is as far up as
        /// it can be. Left out: 0.
        rotation_deg: Option<f64>,
        /// Radii at its start along its two axes, to 1/e² of the irradiance in the middle, mm.
        #[schemars(transform = within(0.0..))]
        waist_radius_mm: [f64; 2],
        /// Half the angle of divergence along its two axes, to 1/e² as well, degrees, below 90. Left out: [0, 0].
        #[schemars(transform = within(0.0..90.0))]
        divergence_deg: Option<[f64; 2]>,
        /// Luminous flux, lm; or give power_w.
        #[schemars(transform = within(0.0..))]
        flux_lm: Option<f64>,
        /// Radiant flux, W, for instance of an infrared beam; or give flux_lm.
        #[schemars(transform = within(0.0..))]
        power_w: Option<f64>,
    }
}
