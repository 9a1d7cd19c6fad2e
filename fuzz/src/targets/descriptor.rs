//! Descriptors of EMVA 1288 image sets, and the sets of those images that are there.

use photosite::characterisation::Descriptor;
use photosite::io::image_sets::read_set;
use crate::written;

pub(crate) fn target(data: &[u8]) {
    if Descriptor::parse(&String::from_utf8_lossy(data)).is_ok() {
        let _ = read_set(&written("set.txt", data), &|| Ok(()));
    }
}
