//! STL files.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use photosite::io::MissingNormals;
use photosite::io::stl::parse;

fuzz_target!(|data: &[u8]| {
    for missing in [MissingNormals::Flat, MissingNormals::Smooth] {
        let _ = parse(data, Path::new("fuzzed.stl"), missing);
    }
});
