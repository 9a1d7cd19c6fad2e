//! Images of textures: PNG, JPEG, WebP, TIFF, PNM, HDR.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = photosite_scene_io::decode(data, "picture");
});
