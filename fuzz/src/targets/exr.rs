//! EXR files of light, electrons and digital numbers.

use std::io::Cursor;

use photosite::io::electrons::electrons;
use photosite::io::exr::read_exr;
use photosite::io::raw_exr::read_raw_exr;
use photosite::io::spectral_exr::irradiance;

pub(crate) fn target(data: &[u8]) {
    let Ok(image) = read_exr(Cursor::new(data)) else { return };
    let _ = irradiance(image.clone());
    let _ = electrons(image);
    if let Ok(raw) = read_raw_exr(Cursor::new(data)) {
        raw.validate().expect("whole");
    }
}
