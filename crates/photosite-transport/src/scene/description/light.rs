//! Light as files describe it: of surfaces, of lamps and of the surroundings.

use std::sync::Arc;

use glam::DAffine3;

use super::texture::{Colour, TextureDescription};
use crate::light::{LightKind, SkyConditions};
use crate::texture::Bitmap;

/// Light that a surface or lamp gives.
#[derive(Clone, Debug)]
pub struct EmissionDescription {
    /// Colour (times D65 for RGB) or spectral shape.
    pub colour: Colour,
    /// Photometric level: luminance in nit for surfaces, luminous intensity in candela for point and spot lights,
    /// illuminance in lux for directional ones. An RGB colour is scaled so that white (1, 1, 1) has this level, as
    /// glTF wants it, a spectrum so that it has this level itself. `None`: the spectrum is absolute (W·m⁻²·sr⁻¹·nm⁻¹, W·sr⁻¹·nm⁻¹,
    /// W·m⁻²·nm⁻¹).
    pub level: Option<f64>,
    /// sRGB-encoded texture on surfaces.
    pub texture: Option<TextureDescription>,
}

/// A light without a surface. It shines along −Z of its node (glTF).
#[derive(Clone, Debug)]
pub struct LightDescription {
    /// Name, for messages.
    pub name: String,
    /// Node → world; only rotation and translation matter.
    pub to_world: DAffine3,
    /// The same at the evenly spaced times that follow in the time of the picture, where it moves.
    pub later: Vec<DAffine3>,
    /// Shape and unit of the level.
    pub kind: LightKind,
    /// Its light. The texture is ignored.
    pub emission: EmissionDescription,
}

/// Light from infinitely far in all directions.
#[derive(Clone, Debug)]
pub enum EnvironmentDescription {
    /// The same radiance everywhere.
    Constant {
        /// Spectral shape or colour.
        colour: Colour,
        /// Luminance in nit (illuminance on a plane is π times that); `None` where the spectrum is absolute.
        luminance_nit: Option<f64>,
    },
    /// An equirectangular picture of linear sRGB; its top row is +Y, its centre looks along −Z before rotation.
    Picture {
        /// Linear, 3 or 4 channels.
        image: Arc<Bitmap>,
        /// What a pixel value of 1 means.
        level: PictureLevel,
        /// Rotation about +Y, counter-clockwise seen from above, degrees.
        rotation_deg: f64,
    },
    /// The sky by day.
    Sky(SkyConditions),
}

/// How the pixel values of an environment picture become luminances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureLevel {
    /// Luminance in nit of a white pixel of value 1.
    NitPerUnit(f64),
    /// The picture is scaled so that it gives this illuminance (lux) on a horizontal plane facing up.
    HorizontalLux(f64),
}
