//! The text of a capture file, with all files that it may name.

use photosite::Capture;
use crate::files;

pub(crate) fn target(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let _ = Capture::parse(text, files(), &[]);
}
