//! OBJ files.

use photosite::io::MissingNormals;
use photosite::io::obj::{Choice, parse};
use crate::files;

pub(crate) fn target(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let _ = parse(
        text,
        &files().join("fuzzed.obj"),
        &Choice { missing_normals: MissingNormals::Smooth, ..Choice::default() },
    );
}
