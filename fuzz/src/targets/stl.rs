//! STL files.

use std::path::Path;

use photosite::io::MissingNormals;
use photosite::io::stl::parse;

pub(crate) fn target(data: &[u8]) {
    for missing in [MissingNormals::Flat, MissingNormals::Smooth] {
        let _ = parse(data, Path::new("fuzzed.stl"), missing);
    }
}
