//! IES files.

use std::path::Path;

use photosite_scene_io::parse_ies;

pub(crate) fn target(data: &[u8]) {
    let _ = parse_ies(data, Path::new("lamp.ies"));
}
