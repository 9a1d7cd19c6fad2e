//! Captures whose keys and kinds of values are right, of the schema, and whose values are anything.

use photosite::Capture;
use crate::{Captures, files};

pub(crate) fn target(data: &[u8]) {
    let Some(capture) = Captures::of(data) else { return };
    let _ = Capture::parse(&capture.text(), files(), &[]);
}
