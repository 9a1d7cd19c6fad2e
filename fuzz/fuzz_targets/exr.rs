//! EXR files of light, electrons and digital numbers.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use photosite::io::electrons::electrons;
use photosite::io::exr::read_exr;
use photosite::io::raw_exr::read_raw_exr;
use photosite::io::spectral_exr::irradiance;

fuzz_target!(|data: &[u8]| {
    let Ok(image) = read_exr(Cursor::new(data)) else { return };
    let _ = irradiance(image.clone());
    let _ = electrons(image);
    if let Ok(raw) = read_raw_exr(Cursor::new(data)) {
        raw.validate().expect("whole");
    }
});
