//! TIFF files of digital numbers.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use photosite::raw::read_tiff;

fuzz_target!(|data: &[u8]| {
    if let Ok(raw) = read_tiff(Cursor::new(data)) {
        raw.validate().expect("whole");
    }
});
