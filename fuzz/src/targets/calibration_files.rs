//! Calibrations of other tools: the first byte chooses the ending, and with it the format.

use std::path::Path;

use photosite::calibration::calibration_files::{CalibrationFile, ENDINGS};

pub(crate) fn target(data: &[u8]) {
    let Some((&choice, text)) = data.split_first() else { return };
    let Ok(text) = std::str::from_utf8(text) else { return };
    let ending = ENDINGS[usize::from(choice) % ENDINGS.len()];
    let _ = CalibrationFile::parse(text, Path::new(&format!("cameras.{ending}")));
}
