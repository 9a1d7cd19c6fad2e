//! IES files.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use photosite_scene_io::parse_ies;

fuzz_target!(|data: &[u8]| {
    let _ = parse_ies(data, Path::new("lamp.ies"));
});
