//! `part.json`, what a part of a render is a part of.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::pipeline::{PART, Parts};
use photosite_fuzz::{folder, written};

fuzz_target!(|data: &[u8]| {
    written(PART, data);
    let _ = Parts::read(&[folder().to_owned()]);
});
