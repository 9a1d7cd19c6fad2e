//! PNM files of digital numbers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::raw::read_pnm;

fuzz_target!(|data: &[u8]| {
    if let Ok(raw) = read_pnm(data) {
        raw.validate().expect("whole");
    }
});
