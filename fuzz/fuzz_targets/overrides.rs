//! `key=value`, one a line, laid over a capture.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::Capture;
use photosite_fuzz::files;

const CAPTURE: &str = include_str!("../files/capture.toml");

fuzz_target!(|text: &str| {
    let overrides: Vec<String> = text.lines().map(str::to_owned).collect();
    let _ = Capture::parse(CAPTURE, files(), &overrides);
});
