//! NPY files of digital numbers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::raw::read_npy;

fuzz_target!(|data: &[u8]| {
    if let Ok(raw) = read_npy(data) {
        raw.validate().expect("whole");
    }
});
