//! OBJ files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::io::MissingNormals;
use photosite::io::obj::{Choice, parse};
use photosite_fuzz::files;

fuzz_target!(|text: &str| {
    let _ = parse(
        text,
        &files().join("fuzzed.obj"),
        &Choice { missing_normals: MissingNormals::Smooth, ..Choice::default() },
    );
});
