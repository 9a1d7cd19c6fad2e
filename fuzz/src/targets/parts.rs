//! `part.json`, what a part of a render is a part of.

use photosite::pipeline::{PART, Parts};
use crate::{folder, written};

pub(crate) fn target(data: &[u8]) {
    written(PART, data);
    let _ = Parts::read(&[folder().to_owned()]);
}
