//! The steps of development, in their order.

use std::borrow::Cow;

use serde::Serialize;

use glam::DVec3;
use photosite_core::Invalid;
use photosite_core::colour::ColourSpace;
use photosite_core::image::{Channel, Planes};
use photosite_core::memory;
use photosite_raw::{Cfa, RawImage, RawMetadata};

use super::choices::NoiseFilter;
use super::choices::{Demosaic, Thresholding, ToneCurve};
use super::description::RawDescription;
use super::encode::{EncodedImage, encode};
use super::memory::{bytes_of_resized, bytes_per_pixel};
use super::merge::Merged;
use super::neighbours::densest;
use super::resampling::Resampling;
use super::settings::DevelopSettings;
use super::{
    black_level, colour, colour_model, convolution, defects, demosaic, highlights, linearisation, noise_filter,
    opcodes, threshold, tone, white_balance,
};

/// Facts found during development.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Development {
    /// The filter array.
    pub cfa: String,
    /// Demosaicking method; `None` where every pixel has all channels.
    pub demosaic: Option<Demosaic>,
    /// The camera's response to what counts as white, per channel, the largest 1.
    pub neutral: Vec<f64>,
    /// Correlated colour temperature of the light that counts as white, K.
    pub temperature_k: Option<f64>,
    /// Tint of the light that counts as white.
    pub tint: Option<f64>,
    /// Width of a pixel of the image over its height.
    pub pixel_aspect: f64,
}

/// Develops to an image for display; grey for a monochrome sensor.
pub fn develop(raw: &RawImage, settings: &DevelopSettings) -> Result<EncodedImage, Invalid> {
    let (image, Development { pixel_aspect, .. }) = develop_linear(raw, settings)?;
    Ok(EncodedImage { pixel_aspect, ..encode(image, &settings.encoding()) })
}

/// Develops to linear planes of the colour space, `R`, `G` and `B` (`X`, `Y` and `Z`), or `Y` for a monochrome sensor.
/// 1 is white at saturation, before the exposure correction.
pub fn develop_linear(raw: &RawImage, settings: &DevelopSettings) -> Result<(Planes, Development), Invalid> {
    raw.validate()?;
    settings.validate()?;
    check_rows(raw, settings)?;
    check_memory([raw.width, raw.height], &raw.cfa, settings)?;
    let raw = settings.raw.apply(raw).map_err(|invalid| invalid.within("raw"))?;
    let raw = opcodes::on_stored(&raw, settings.lens_falloff);
    let raw = linearisation::apply(&raw, settings.linearisation);
    let raw = if raw.active_area.is_some() { Cow::Owned(raw.cropped()) } else { raw };
    let signal = black_level::subtract(&raw, settings.black_level);
    develop_signal(signal, &raw, settings).map_err(|invalid| settings.raw.blamed(invalid))
}

/// Refuses what needs rows whose pixels stand in columns.
fn check_rows(raw: &RawImage, settings: &DevelopSettings) -> Result<(), Invalid> {
    if !raw.metadata.is_staggered {
        return Ok(());
    }
    let on_columns = [
        ("noise_filter", settings.noise_filter != NoiseFilter::None),
        ("kernel", settings.kernel.is_some()),
        ("resize_px", settings.resizes() && !settings.square_pixels),
    ];
    match on_columns.into_iter().find(|(_, is_set)| *is_set) {
        Some((key, _)) => {
            let message = "works on rows and columns, and the rows of hexagonal cells are staggered";
            Err(Invalid::new(key, message).help("remove it, or treat the developed image, which has square pixels"))
        }
        None => Ok(()),
    }
}

/// Refuses an image whose development takes more memory than there is.
fn check_memory([width, height]: [usize; 2], cfa: &Cfa, settings: &DevelopSettings) -> Result<(), Invalid> {
    let bytes = (width as u64 * height as u64).saturating_mul(bytes_per_pixel(cfa, settings));
    let bytes = bytes.saturating_add(bytes_of_resized(cfa, settings));
    let resized = settings.resize_px.map_or_else(String::new, |[columns, rows]| format!(" to {columns} × {rows}"));
    memory::check(bytes, &format!("developing {width} × {height} pixels{resized}"), "")
}

/// Develops an image that is linear light already, R, G and B of sRGB or Y alone, with white at 1: what of the steps
/// is not of raw files. The pixels are `pixel_aspect` times as wide as high.
pub fn develop_image(
    image: Planes,
    pixel_aspect: f64,
    settings: &DevelopSettings,
) -> Result<(Planes, Development), Invalid> {
    settings.validate()?;
    let is_grey = image.channels().len() == 1;
    let cfa = if is_grey { Cfa::mono() } else { Cfa::full(["R", "G", "B"])? };
    check_memory([image.width(), image.height()], &cfa, settings)?;
    let metadata = RawMetadata { stated_pixel_aspect: Some(pixel_aspect), ..RawMetadata::default() };
    let neutral = vec![1.0; cfa.channels().len()];
    let image = filtered(image, &metadata, &neutral, settings)?;
    let (space, factor) = (settings.colour_space, settings.exposure_ev.exp2());
    let image = if is_grey || space == ColourSpace::Srgb {
        if factor == 1.0 { image } else { image.scaled(factor) }
    } else {
        let matrix = space.from_xyz(ColourSpace::Srgb.white()) * ColourSpace::Srgb.to_xyz();
        colour::apply(image, &[DVec3::X, DVec3::Y, DVec3::Z].map(|axis| matrix * axis), space, factor)
    };
    let development = Development {
        cfa: cfa.to_string(),
        demosaic: None,
        neutral,
        temperature_k: None,
        tint: None,
        pixel_aspect: settings.pixel_aspect(&metadata),
    };
    Ok((shown(image, settings), development))
}

/// Develops the light of a bracket to linear planes as [`develop_linear`] does, but for tone curve and threshold. 1 is white at saturation in the longest
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
    check_memory([merged.raw.width, merged.raw.height], &merged.raw.cfa, settings)?;
    let settings =
        &DevelopSettings { tone_curve: ToneCurve::Linear, threshold: Thresholding::None, ..settings.clone() };
    let Merged { signal, raw, times_s: [shortest, longest], .. } = merged;
    let (image, development) = develop_signal(signal, &raw, settings)?;
    Ok((image.scaled(longest / shortest), development))
}

/// Develops a signal of 0 for no light and 1 for saturation. The pixel values of `raw` do not count.
fn develop_signal(
    mut signal: Vec<f32>,
    raw: &RawImage,
    settings: &DevelopSettings,
) -> Result<(Planes, Development), Invalid> {
    let size = [raw.width, raw.height];
    let orientation = settings.orientation(&raw.metadata);
    // Size and kernel are meant for the turned image.
    let settings = &DevelopSettings {
        resize_px: settings.resize_px.map(|size| orientation.turned(size)),
        kernel: settings.kernel.as_ref().map(|kernel| orientation.kernel_before(kernel)),
        ..settings.clone()
    };
    defects::correct(&mut signal, size, &raw.cfa, settings.defects);
    opcodes::on_signal(&mut signal, raw, settings.lens_falloff);
    let neutral = white_balance::neutral(raw, &signal, settings)?;
    white_balance::apply(&mut signal, raw, &neutral, highlights::ceiling(settings.highlights));
    let mut image = demosaic::demosaic(&signal, raw, settings.demosaic)?;
    drop(signal);
    opcodes::on_planes(&mut image, raw, &neutral, settings.lens_falloff);
    highlights::recover(&mut image, &neutral, settings.highlights);
    let image = filtered(image, &raw.metadata, &neutral, settings)?;
    let image = shown(to_colour_space(image, raw, &neutral, settings)?, settings);
    let image = orientation.apply(image);

    let light = colour::temperature_of(&raw.metadata, &neutral);
    let development = Development {
        cfa: raw.cfa.to_string(),
        demosaic: if raw.cfa.is_mosaic() { Some(demosaic::method_for(raw, settings.demosaic)?) } else { None },
        temperature_k: light.map(|(kelvin, _)| kelvin),
        tint: light.map(|(_, tint)| tint),
        pixel_aspect: orientation.pixel_aspect(settings.pixel_aspect(&raw.metadata)),
        neutral,
    };
    Ok((image, development))
}

/// Applies noise filter and kernel, and resamples.
fn filtered(
    mut image: Planes,
    metadata: &RawMetadata,
    neutral: &[f64],
    settings: &DevelopSettings,
) -> Result<Planes, Invalid> {
    noise_filter::apply(&mut image, settings, &metadata.noise_profile, neutral);
    convolution::apply(&mut image, settings)?;
    let resampling = Resampling::new(metadata, [image.width(), image.height()], settings);
    Ok(match resampling {
        Some(resampling) => resampling.apply(image),
        None => image,
    })
}

/// The light that is shown: tone curve, luminance alone, threshold.
pub(super) fn shown(mut image: Planes, settings: &DevelopSettings) -> Planes {
    tone::apply(&mut image, settings);
    image = colour_model::to_grey(image, settings);
    threshold::apply(&mut image, settings);
    image
}

/// Colour matrix and exposure in one pass.
fn to_colour_space(
    mut camera: Planes,
    raw: &RawImage,
    neutral: &[f64],
    settings: &DevelopSettings,
) -> Result<Planes, Invalid> {
    let (matrix, factor) = matrix_and_exposure(&raw.metadata, neutral, settings)?;
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

/// Matrix from white-balanced camera channels to the colour space, a column per channel, where there is one, and the
/// factor of the exposure corrections.
pub(super) fn matrix_and_exposure(
    metadata: &RawMetadata,
    neutral: &[f64],
    settings: &DevelopSettings,
) -> Result<(Option<Vec<DVec3>>, f64), Invalid> {
    let factor = (metadata.baseline_exposure_ev + settings.exposure_ev).exp2();
    let matrix =
        if settings.colour_matrix { colour::camera_to_rgb(metadata, neutral, settings.colour_space)? } else { None };
    Ok((matrix, factor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_raw::Orientation;

    /// An image that is stored turned is developed as the one that stands upright, whatever is asked for.
    #[test]
    fn settings_are_meant_for_the_image_upright() {
        let [width, height] = [16, 10];
        let upright: Vec<u16> = (0..width * height).map(|i| (i * i * 37 % 50_000) as u16).collect();
        let kernel = Some(vec![vec![0.1, 0.5, 0.2, 0.0, -0.1]; 3]);
        let row = Some(vec![vec![-1.0, 0.0, 3.0]]);
        let plain = DevelopSettings::default();
        for settings in [
            plain.clone(),
            DevelopSettings { kernel: kernel.clone(), ..plain.clone() },
            DevelopSettings { kernel: row, ..plain.clone() },
            DevelopSettings { resize_px: Some([7, 4]), ..plain.clone() },
            DevelopSettings { resize_px: Some([24, 15]), kernel: kernel.clone(), ..plain.clone() },
        ] {
            let develop = |raw: &RawImage| develop_linear(raw, &settings).expect("an image").0;
            let expected = develop(&RawImage::bare(width, height, upright.clone(), Cfa::mono(), u16::MAX));
            for number in 1..=8u8 {
                let orientation = Orientation::of_number(number.into()).expect("one of eight");
                // An image of numbers says where each pixel of the upright one is stored.
                let [columns, rows] = orientation.turned([width, height]);
                let numbers = (0..width * height).map(|i| i as f32).collect();
                let places = Planes::new(columns, rows, vec![Channel { name: "Y".to_owned(), data: numbers }]);
                let places = orientation.apply(places.expect("right size"));
                let mut stored = vec![0; width * height];
                for (place, value) in places.channels()[0].data.iter().zip(&upright) {
                    stored[*place as usize] = *value;
                }
                let mut raw = RawImage::bare(columns, rows, stored, Cfa::mono(), u16::MAX);
                raw.metadata.orientation = orientation;
                let found = develop(&raw);
                assert_eq!([found.width(), found.height()], [expected.width(), expected.height()]);
                for (found, expected) in found.channels()[0].data.iter().zip(&expected.channels()[0].data) {
                    // Sums of weights in another order, of 32-bit floats.
                    assert!((found - expected).abs() < 1e-5, "{number} {settings:?}: {found} {expected}");
                }
            }
        }
    }
}
