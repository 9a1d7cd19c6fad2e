//! `[[lights]]`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::sensor::SpectrumSource;

use super::LightColour;

/// A light without a surface.
#[derive(Debug, JsonSchema)]
#[schemars(tag = "type", rename_all = "kebab-case")]
pub(crate) enum LightTable {
    /// The same intensity in all directions.
    Point(PointTable),
    /// Intensity within a cone.
    Spot(SpotTable),
    /// From infinitely far in one direction, as the sun.
    Directional(DirectionalTable),
    /// A lamp whose intensity was measured in many directions: an IES file.
    Profile(ProfileTable),
    /// A slide that a lens throws.
    Projector(ProjectorTable),
}

/// The value of `type`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum LightType {
    Point,
    Spot,
    Directional,
    Profile,
    Projector,
}

/// Declares a light's table: the keys that all have, and its own.
macro_rules! light_table {
    ($(#[$attribute:meta])* $name:ident { $($(#[doc = $doc:literal])* $key:ident: $kind:ty,)* }) => {
        $(#[$attribute])*
        #[derive(Debug, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $name {
            /// Name, for messages.
            pub(crate) name: Option<String>,
            $($(#[doc = $doc])* pub(crate) $key: $kind,)*
            /// Name of an illuminant: "D65", "A", "F11", "LED-B3", "3000K" (a blackbody) … Left out, as are the other
            /// colours: "D65".
            pub(crate) illuminant: Option<String>,
            /// A spectrum: the name of one that ships with photosite, { file = "lamp.csv" }, or a number for equal energy.
            pub(crate) spectrum: Option<SpectrumSource>,
            /// sRGB as displayed, 0–1 each.
            pub(crate) rgb: Option<[f64; 3]>,
            /// Linear sRGB.
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
    /// The same intensity in all directions.
    PointTable {
        /// Where it is, m.
        position_m: [f64; 3],
        /// Luminous intensity, cd.
        intensity_cd: f64,
    }
}

light_table! {
    /// Intensity within a cone, falling off smoothly between two angles.
    SpotTable {
        /// Where it is, m.
        position_m: [f64; 3],
        /// A point that it shines at, m; or give its direction.
        look_at_m: Option<[f64; 3]>,
        /// The direction that it shines in, of any length; or give look_at_m.
        direction: Option<[f64; 3]>,
        /// Luminous intensity on its axis, cd.
        intensity_cd: f64,
        /// Angle from the axis up to which the intensity is full, degrees. Left out: 0.
        inner_angle_deg: Option<f64>,
        /// Angle from the axis beyond which there is no light, degrees, at most 90.
        outer_angle_deg: f64,
    }
}

light_table! {
    /// From infinitely far in one direction, as the sun.
    DirectionalTable {
        /// The direction that it shines in, of any length: [0, -1, 0] is from above.
        direction: [f64; 3],
        /// Illuminance on a plane across the direction, lux.
        illuminance_lux: f64,
    }
}

light_table! {
    /// A lamp whose intensity was measured in many directions.
    ProfileTable {
        /// An IES file (LM-63), relative to this one. Its vertical angle 0 is the direction that the lamp shines in.
        file: String,
        /// Where it is, m; or give gltf_light.
        position_m: Option<[f64; 3]>,
        /// Name of a light of the geometry whose place it takes.
        gltf_light: Option<String>,
        /// A point that it shines at, m; or give its direction.
        look_at_m: Option<[f64; 3]>,
        /// The direction that it shines in, of any length; or give look_at_m. Left out, as is look_at_m: down, or that of
        /// gltf_light.
        direction: Option<[f64; 3]>,
        /// Turns it about that direction, degrees, clockwise seen from behind the lamp.
        rotation_deg: Option<f64>,
        /// Luminous flux, lm, in place of that of the file.
        flux_lm: Option<f64>,
    }
}

light_table! {
    /// A slide that a lens throws.
    ProjectorTable {
        /// The slide: PNG, JPEG or WebP, sRGB, relative to this file.
        image: String,
        /// Where the lens is, m; or give gltf_camera.
        position_m: Option<[f64; 3]>,
        /// A point on its axis, m.
        look_at_m: Option<[f64; 3]>,
        /// What is up in the picture. Left out: [0, 1, 0].
        up: Option<[f64; 3]>,
        /// Name of a camera of the geometry in whose place it stands, with its field of view.
        gltf_camera: Option<String>,
        /// Angle over the width of the picture, degrees; or give focal_length_px.
        horizontal_fov_deg: Option<f64>,
        /// fx and fy of the pinhole matrix in pixels of the slide.
        focal_length_px: Option<[f64; 2]>,
        /// cx and cy from the top-left corner of the slide. Left out: its middle.
        principal_point_px: Option<[f64; 2]>,
        /// Diameter of the opening, mm. Left out: 0, sharp everywhere.
        aperture_mm: Option<f64>,
        /// Distance of what is sharp, m; needed with aperture_mm.
        focus_distance_m: Option<f64>,
        /// Luminous flux with a white slide, lm.
        flux_lm: f64,
    }
}
