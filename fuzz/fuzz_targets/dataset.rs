//! Data set files, and what their first frames are.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::Sandbox;
use photosite::dataset::DataSet;
use photosite::pipeline::{FilmMemory, Silent};
use photosite_fuzz::written;

fuzz_target!(|data: &[u8]| {
    let path = written("dataset.toml", data);
    if let Ok(set) = DataSet::read(&Sandbox::default(), &path, &[], FilmMemory::default()) {
        let _ = set.frames(0..2, false, &Silent);
    }
});
