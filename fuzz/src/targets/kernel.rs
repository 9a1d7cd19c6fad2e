//! CSV files of measured point spread functions.

use photosite::Capture;
use crate::{folder, written};

const CAPTURE: &str = include_str!("../../files/capture.toml");

pub(crate) fn target(data: &[u8]) {
    written("kernel.csv", data);
    let lens = r#"lens.psf={ kind = "kernel", pitch_um = 1, kernels = [{ file = "kernel.csv" }] }"#;
    let _ = Capture::parse(CAPTURE, folder(), &[lens.to_owned()]);
}
