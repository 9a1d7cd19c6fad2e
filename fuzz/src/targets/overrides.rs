//! `key=value`, one a line, laid over a capture.

use photosite::Capture;
use crate::files;

const CAPTURE: &str = include_str!("../../files/capture.toml");

pub(crate) fn target(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let overrides: Vec<String> = text.lines().map(str::to_owned).collect();
    let _ = Capture::parse(CAPTURE, files(), &overrides);
}
