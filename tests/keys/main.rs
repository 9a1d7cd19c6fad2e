//! Keys of captures, data sets and noise: schemas, the code that reads them, and builders agree on every key.

mod builders;
mod finite;
mod ranges;

use std::fs;
use std::path::Path;

use tempfile::TempDir;

/// A room of three materials, no MTL file.
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\n\
                   usemtl wall\nf 1/1 2/1 3/2\nusemtl lamp\nf 1 3 4\nusemtl ball.glass\nf 2 3 4\n";

/// A folder with a capture file and what it refers to.
struct Files(TempDir);

impl Files {
    fn new(capture: &str) -> Self {
        let files = Self(tempfile::tempdir().expect("temporary folder"));
        files.add("room.obj", OBJ.as_bytes());
        files.add("capture.toml", capture.as_bytes());
        files
    }

    fn add(&self, name: &str, bytes: &[u8]) {
        fs::write(self.0.path().join(name), bytes).expect("written");
    }
}

/// A valid capture file with more lines behind it.
fn room(more: &str) -> String {
    format!(
        "[scene]\ngeometry = [\"room.obj\"]\nenvironment = {{ illuminant = \"D65\", illuminance_lux = 500 }}\n{more}"
    )
}

fn capture(text: &str) -> photosite::Capture {
    let files = Files::new(text);
    photosite::Capture::load_with(&files.0.path().join("capture.toml"), &[]).unwrap_or_else(|error| panic!("{error}"))
}
