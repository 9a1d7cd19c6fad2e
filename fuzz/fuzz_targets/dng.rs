//! DNG files of digital numbers.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use photosite::raw::read_dng;

fuzz_target!(|data: &[u8]| {
    if let Ok(raw) = read_dng(Cursor::new(data)) {
        raw.validate().expect("whole");
    }
});
