//! CSV files of measured point spread functions.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::Capture;
use photosite_fuzz::{folder, written};

const CAPTURE: &str = include_str!("../files/capture.toml");

fuzz_target!(|data: &[u8]| {
    written("kernel.csv", data);
    let lens = r#"lens.psf={ kind = "kernel", pitch_um = 1, kernels = [{ file = "kernel.csv" }] }"#;
    let _ = Capture::parse(CAPTURE, folder(), &[lens.to_owned()]);
});
