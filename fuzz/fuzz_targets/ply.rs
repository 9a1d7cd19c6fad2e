//! PLY files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::Sandbox;
use photosite::io::ply::parse;
use photosite::io::{ChangedMeshes, MissingNormals, complete};
use photosite_fuzz::files;

fuzz_target!(|data: &[u8]| {
    for missing in [MissingNormals::Flat, MissingNormals::Smooth] {
        if let Ok(mut scene) = parse(data, &files().join("fuzzed.ply"), missing, &Sandbox::default()) {
            complete(&mut scene, &mut ChangedMeshes::default());
        }
    }
});
