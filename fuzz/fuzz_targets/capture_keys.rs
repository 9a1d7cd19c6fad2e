//! Captures whose keys and kinds of values are right, of the schema, and whose values are anything.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::Capture;
use photosite_fuzz::{Captures, files};

fuzz_target!(|capture: Captures| {
    let _ = Capture::parse(&capture.text(), files(), &[]);
});
