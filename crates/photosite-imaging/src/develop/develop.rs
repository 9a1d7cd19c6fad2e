//! The steps of development, in their order.

use std::borrow::Cow;

use serde::Serialize;

use crate::raw::RawImage;
use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};
use photosite_core::memory;

use super::description::RawDescription;
use super::encode::{EncodedPicture, encode};
use super::memory::bytes_per_pixel;
use super::merge::Merged;
use super::neighbours::densest;
use super::resampling::Resampling;
use super::settings::{Demosaic, DevelopSettings, NoiseFilter};
use super::{
    black_level, colour, defects, demosaic, highlights, lens_falloff, linearisation, noise_filter, tone, white_balance,
};

/// What was found out on the way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Development {
    /// The filter array.
    pub cfa: String,
    /// How its channels were found; `None` where every pixel has all of them.
    pub demosaic: Option<Demosaic>,
    /// The camera's response to what counts as white, per channel, the largest 1.
    pub neutral: Vec<f64>,
    /// Colour temperature of that light, K.
    pub temperature_k: Option<f64>,
    /// Its tint.
    pub tint: Option<f64>,
    /// Width of a pixel of the picture over its height.
    pub pixel_aspect: f64,
}

/// Develops to a picture for display; grey for a monochrome sensor.
pub fn develop(raw: &RawImage, settings: &DevelopSettings) -> Result<EncodedPicture, Invalid> {
    let (picture, Development { pixel_aspect, .. }) = develop_linear(raw, settings)?;
    Ok(EncodedPicture { pixel_aspect, ..encode(picture, &settings.encoding()) })
}

/// Develops to linear planes of the colour space, `R`, `G` and `B` (`X`, `Y` and `Z`), or `Y` for a monochrome sensor.
/// 1 is white at saturation, before the exposure correction.
pub fn develop_linear(raw: &RawImage, settings: &DevelopSettings) -> Result<(Planes, Development), Invalid> {
    raw.validate()?;
    settings.validate()?;
    check_rows(raw, settings)?;
    check_memory(raw, settings)?;
    let raw = settings.raw.apply(raw).map_err(|invalid| invalid.within("raw"))?;
    let raw = linearisation::apply(&raw, settings.linearisation);
    let raw = if raw.active_area.is_some() { Cow::Owned(raw.cropped()) } else { raw };
    let signal = black_level::subtract(&raw, settings.black_level);
    develop_signal(signal, &raw, settings)
}

/// Refuses what needs rows whose pixels stand in columns.
fn check_rows(raw: &RawImage, settings: &DevelopSettings) -> Result<(), Invalid> {
    if raw.metadata.is_staggered && settings.noise_filter != NoiseFilter::None {
        let message = "works on rows and columns, and the rows of hexagonal cells are staggered";
        return Err(Invalid::new("noise_filter", message).help("remove it, or filter the developed picture"));
    }
    Ok(())
}

/// Refuses a picture whose development takes more memory than there is.
fn check_memory(raw: &RawImage, settings: &DevelopSettings) -> Result<(), Invalid> {
    let bytes = (raw.width as u64 * raw.height as u64).saturating_mul(bytes_per_pixel(&raw.cfa, settings));
    memory::check(bytes, &format!("developing {} × {} pixels", raw.width, raw.height), "")
}

/// Develops the light of a bracket to linear planes as [`develop_linear`] does. 1 is white at saturation in the longest
/// exposure, above which the shorter ones reach.
pub fn develop_merged(merged: Merged, settings: &DevelopSettings) -> Result<(Planes, Development), Invalid> {
    settings.validate()?;
    check_rows(&merged.raw, settings)?;
    let default = RawDescription::default();
    for (key, is_default) in [
        ("raw", settings.raw == default),
        ("linearisation", settings.linearisation),
        ("black_level", settings.black_level),
    ] {
        if !is_default {
            let message = "a bracket is merged from linear light, as its files say";
            return Err(Invalid::new(key, message).help(format!("remove {key}")));
        }
    }
    check_memory(&merged.raw, settings)?;
    let Merged { signal, raw, times_s: [shortest, longest], .. } = merged;
    let (picture, development) = develop_signal(signal, &raw, settings)?;
    Ok((picture.scaled(longest / shortest), development))
}

/// The steps from a signal of 0 for no light and 1 for saturation on. The numbers of `raw` do not count.
fn develop_signal(
    mut signal: Vec<f32>,
    raw: &RawImage,
    settings: &DevelopSettings,
) -> Result<(Planes, Development), Invalid> {
    let size = [raw.width, raw.height];
    defects::correct(&mut signal, size, &raw.cfa, settings.defects);
    if settings.lens_falloff {
        lens_falloff::correct(&mut signal, raw);
    }
    let neutral = white_balance::neutral(raw, &signal, settings)?;
    white_balance::apply(&mut signal, raw, &neutral, highlights::ceiling(settings.highlights));
    let mut picture = demosaic::demosaic(&signal, raw, settings.demosaic)?;
    drop(signal);
    highlights::recover(&mut picture, &neutral, settings.highlights);
    noise_filter::apply(&mut picture, settings, &raw.metadata.noise_profile, &neutral);
    if let Some(resampling) = Resampling::new(&raw.metadata, size, settings) {
        picture = resampling.apply(picture);
    }
    let mut picture = to_colour_space(picture, raw, &neutral, settings)?;
    tone::apply(&mut picture, settings.tone_curve);

    let light = colour::temperature_of(&raw.metadata, &neutral);
    let development = Development {
        cfa: raw.cfa.to_string(),
        demosaic: if raw.cfa.is_mosaic() { Some(demosaic::method_for(raw, settings.demosaic)?) } else { None },
        temperature_k: light.map(|(kelvin, _)| kelvin),
        tint: light.map(|(_, tint)| tint),
        pixel_aspect: settings.pixel_aspect(&raw.metadata),
        neutral,
    };
    Ok((picture, development))
}

/// Colour matrix and exposure in one pass.
fn to_colour_space(
    mut camera: Planes,
    raw: &RawImage,
    neutral: &[f64],
    settings: &DevelopSettings,
) -> Result<Planes, Invalid> {
    let factor = (raw.metadata.baseline_exposure_ev + settings.exposure_ev).exp2();
    let matrix = if settings.colour_matrix {
        colour::camera_to_rgb(&raw.metadata, neutral, settings.colour_space)?
    } else {
        None
    };
    if let Some(columns) = matrix {
        return Ok(colour::apply(camera, &columns, settings.colour_space, factor));
    }
    // Without a matrix, three channels are shown as they are and of others the densest in grey.
    if camera.channels().len() != 3 {
        let densest = densest(&raw.cfa);
        let data = std::mem::take(&mut camera.channels_mut()[densest].data);
        camera = Planes::new(camera.width(), camera.height(), vec![Channel { name: "Y".to_owned(), data }])?;
    }
    Ok(if factor == 1.0 { camera } else { camera.scaled(factor) })
}
