//! Light as files describe it: of surfaces, of lights without a surface and of the surroundings.

use std::sync::Arc;

use glam::DAffine3;

use super::texture::{Colour, TextureDescription};
use crate::light::{LightKind, SkyConditions};
use crate::texture::Bitmap;

/// Light that a surface or a light without a surface gives.
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
    /// Transforms node → world at the evenly spaced times that follow in the time of the image, where the light moves.
    pub later: Vec<DAffine3>,
    /// Shape and unit of the level.
    pub kind: LightKind,
    /// Emission of the light; its texture is ignored.
    pub emission: EmissionDescription,
}

/// Light from infinitely far in all directions.
#[derive(Clone, Debug)]
pub enum EnvironmentDescription {
    /// Constant radiance in all directions.
    Constant {
        /// Spectral shape or colour.
        colour: Colour,
        /// Luminance in nit (illuminance on a plane is π times that); `None` where the spectrum is absolute.
        luminance_nit: Option<f64>,
    },
    /// An equirectangular image of linear sRGB; its top row is +Y, its centre looks along −Z before rotation.
    Image {
        /// Linear, 3 or 4 channels.
        image: Arc<Bitmap>,
        /// Luminance that a pixel value of 1 stands for.
        level: ImageLevel,
        /// Rotation about +Y, counter-clockwise seen from above, degrees.
        rotation_deg: f64,
    },
    /// The sky by day.
    Sky(SkyConditions),
}

/// Scale from the pixel values of an environment image to luminances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImageLevel {
    /// Luminance in nit of a white pixel of value 1.
    NitPerUnit(f64),
    /// Illuminance (lux) that the image gives on a horizontal plane facing up.
    HorizontalLux(f64),
}
