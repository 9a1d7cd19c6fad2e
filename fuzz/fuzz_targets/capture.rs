//! The text of a capture file, with all files that it may name.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::Capture;
use photosite_fuzz::files;

fuzz_target!(|text: &str| {
    let _ = Capture::parse(text, files(), &[]);
});
