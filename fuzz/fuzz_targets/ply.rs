//! PLY files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::Sandbox;
use photosite::io::MissingNormals;
use photosite::io::complete;
use photosite::io::ply::parse;
use photosite_fuzz::files;

fuzz_target!(|data: &[u8]| {
    for missing in [MissingNormals::Flat, MissingNormals::Smooth] {
        if let Ok(mut scene) = parse(data, &files().join("fuzzed.ply"), missing, &Sandbox::default()) {
            complete(&mut scene);
        }
    }
});
