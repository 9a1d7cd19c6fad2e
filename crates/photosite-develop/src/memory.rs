//! Memory that development takes.

use photosite_raw::Cfa;

use super::choices::{NoiseFilter, ToneCurve};
use super::settings::DevelopSettings;

/// Bytes of a number in a plane.
const FLOAT: u64 = 4;

/// Bytes of a pixel that developing takes beside the raw image, at the step that takes most: the signal with the planes
/// that are made of it, planes beside those that a filter makes of them, or planes and their codes.
pub fn bytes_per_pixel(cfa: &Cfa, settings: &DevelopSettings) -> u64 {
    let planes = cfa.channels().len() as u64 * FLOAT;
    let signal = cfa.samples_per_pixel() as u64 * FLOAT;
    let filters = settings.noise_filter != NoiseFilter::None
        || settings.kernel.is_some()
        || settings.resizes()
        || settings.sharpening > 0.0
        || settings.square_pixels
        || settings.distortion;
    let of_filter = if filters { planes } else { 0 };
    // Luminance before and after, and what the local curve takes in between.
    let of_tone = match settings.tone_curve {
        ToneCurve::Linear | ToneCurve::Srgb | ToneCurve::Gamma | ToneCurve::Filmic => 0,
        ToneCurve::Reinhard | ToneCurve::Log => 2 * FLOAT,
        ToneCurve::Local => 6 * FLOAT,
    };
    // Codes, and a row of them as files have it.
    let codes = cfa.channels().len() as u64 * (u64::from(settings.bits / 8) + 1);
    planes + signal.max(of_filter).max(of_tone).max(codes)
}

/// Bytes that the pixels take which the settings resize an image to, beside those that it had.
pub fn bytes_of_resized(cfa: &Cfa, settings: &DevelopSettings) -> u64 {
    let [columns, rows] = settings.resize_px.unwrap_or_default().map(|n| n as u64);
    columns.saturating_mul(rows).saturating_mul(bytes_per_pixel(cfa, settings))
}
