//! MTL files, as an OBJ file reads them.

use photosite::io::obj::{Choice, parse};
use crate::written;

const OBJ: &str = "mtllib fuzzed.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\nusemtl b\nf 1 2 3\n";

pub(crate) fn target(data: &[u8]) {
    let path = written("fuzzed.mtl", data);
    let _ = parse(OBJ, &path.with_extension("obj"), &Choice::default());
}
