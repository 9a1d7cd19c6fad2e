//! The steps of development, in their order.

use crate::Invalid;
use crate::image::{Channel, Planes};
use crate::raw::RawImage;

use super::encode::{Picture8, encode_srgb};
use super::white_balance::{self, WhiteBalance};
use super::{black_level, colour, demosaic, exposure};

/// How to develop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DevelopSettings {
    /// What counts as white.
    pub white_balance: WhiteBalance,
    /// Brightening by 2^ev; what passes 1 is white.
    pub exposure_ev: f64,
}

/// Develops to an 8-bit sRGB picture; grey for a monochrome sensor.
pub fn develop(raw: &RawImage, settings: &DevelopSettings) -> Result<Picture8, Invalid> {
    Ok(encode_srgb(&develop_linear(raw, settings)?))
}

/// Develops to linear sRGB, planes `R`, `G` and `B`, or `Y` for a monochrome sensor. 1 is white at saturation, before
/// the exposure correction.
pub fn develop_linear(raw: &RawImage, settings: &DevelopSettings) -> Result<Planes, Invalid> {
    raw.validate()?;
    if raw.active_area.is_some() {
        return develop_linear(&raw.cropped(), settings);
    }
    if !(raw.cfa.is_mono() || raw.cfa.is_bayer()) {
        let message = format!("a picture with the colour filter array {} cannot be developed", raw.cfa);
        return Err(Invalid::new("cfa", message).help("photosite develops Bayer mosaics and monochrome pictures"));
    }
    let mut mosaic = black_level::subtract(raw);
    if raw.cfa.is_mono() {
        let grey = Channel { name: "Y".to_owned(), data: mosaic };
        return Ok(exposure::apply(Planes::new(raw.width, raw.height, vec![grey])?, settings.exposure_ev));
    }
    let neutral = settings.white_balance.neutral(raw)?;
    let to_srgb = colour::camera_to_srgb(&raw.metadata, neutral)?;
    white_balance::apply(&mut mosaic, raw, neutral);
    let mut picture = demosaic::demosaic(&mosaic, raw.width, raw.height, &raw.cfa);
    colour::apply(&mut picture, to_srgb);
    Ok(exposure::apply(picture, settings.exposure_ev))
}
