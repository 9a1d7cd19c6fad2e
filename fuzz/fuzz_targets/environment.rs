//! Environment images: HDR and EXR.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite_core::warnings::Warnings;
use photosite_scene_io::decode_environment;

fuzz_target!(|data: &[u8]| {
    let _ = decode_environment(data, "sky".to_owned(), &mut Warnings::default());
});
