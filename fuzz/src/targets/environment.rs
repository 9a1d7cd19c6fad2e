//! Environment images: HDR and EXR.

use photosite_core::warnings::Warnings;
use photosite_scene_io::decode_environment;

pub(crate) fn target(data: &[u8]) {
    let _ = decode_environment(data, "sky".to_owned(), &mut Warnings::default());
}
