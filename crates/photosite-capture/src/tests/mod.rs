//! Tests of whole captures, made here.

mod calibration;
mod encodings;
mod errors;
mod levels;
mod objects;
mod prescription;
mod scene_warnings;
mod values;

use std::fs;

use tempfile::TempDir;

use super::*;

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

    fn read(&self, overrides: &[&str]) -> Result<Capture> {
        let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
        Capture::load_with(&self.0.path().join("capture.toml"), &overrides)
    }
}

/// A valid capture file with more lines behind it.
fn room(more: &str) -> String {
    format!(
        "[scene]\ngeometry = [\"room.obj\"]\nenvironment = {{ illuminant = \"D65\", illuminance_lux = 500 }}\n{more}"
    )
}

fn capture(text: &str) -> Capture {
    Files::new(text).read(&[]).unwrap_or_else(|error| panic!("{error}"))
}
