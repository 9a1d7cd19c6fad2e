//! Pixel pitch of an image, as stated by its file or the report beside it.

use std::path::Path;

use super::{REPORT, Report};
use photosite_core::{Invalid, Result};
use photosite_files::raw_file::{is_mosaic, read_raw};

/// Width and height of the pixels of an image file of `size` columns and rows, m: from a DNG file's focal plane
/// resolution, else from the sensor in the report that lists the file. `None` where neither is there, and for images of
/// other pixels than those of the sensor.
///
/// # Errors
///
/// A DNG file that cannot be read.
pub fn pixel_pitch_m(path: &Path, size: [usize; 2]) -> Result<Option<[f64; 2]>> {
    if is_mosaic(path)
        && let Some(pitch_m) = read_raw(path)?.metadata.pixel_pitch_m
    {
        return Ok(Some(pitch_m));
    }
    let name = path.file_name().map(|name| name.to_string_lossy());
    let of_report = |report: Report| {
        let is_listed = report.files.iter().any(|file| Some(&**file) == name.as_deref());
        let is_moved = report.image.is_some_and(|image| image.is_resampled)
            && name.as_deref().is_some_and(|name| name.starts_with("image"));
        let is_of_sensor = report.sensor.resolution_px == size && !is_moved;
        (is_listed && is_of_sensor).then_some(report.sensor.pixel_pitch_um.map(|um| um * 1e-6))
    };
    // The image is measured whatever lies beside it.
    Ok(Report::read(&path.with_file_name(REPORT)).ok().and_then(of_report))
}

/// Stated width and height of pixels, m, from one number for both or two numbers, µm.
///
/// # Errors
///
/// Numbers that are not above 0, or other than one or two.
pub fn stated_pitch_m(um: &[f64]) -> std::result::Result<[f64; 2], Invalid> {
    let pitch = match *um {
        [both] => [both; 2],
        [x, y] => [x, y],
        _ => {
            let message = format!("{} numbers instead of 1 or 2", um.len());
            return Err(Invalid::new("pitch-um", message).help("for example --pitch-um 3.45"));
        }
    };
    if pitch.iter().all(|um| um.is_finite() && *um > 0.0) {
        return Ok(pitch.map(|um| um * 1e-6));
    }
    let message = format!("must be above 0 and finite, got {}", pitch.map(|um| um.to_string()).join(", "));
    Err(Invalid::new("pitch-um", message).help("give the pitch of the pixels in µm, for example --pitch-um 3.45"))
}
