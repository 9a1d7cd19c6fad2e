//! OBJ files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::Sandbox;
use photosite::io::MissingNormals;
use photosite::io::obj::parse;
use photosite_fuzz::files;

fuzz_target!(|text: &str| {
    let _ = parse(text, &files().join("fuzzed.obj"), MissingNormals::Smooth, &Sandbox::default());
});
