//! `manifest.jsonl`, the list of the images of a data set.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::dataset::read_dataset;
use photosite_fuzz::{folder, written};

fuzz_target!(|data: &[u8]| {
    written("manifest.jsonl", data);
    let _ = read_dataset(folder());
});
