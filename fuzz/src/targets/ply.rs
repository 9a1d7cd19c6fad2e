//! PLY files.

use photosite::Sandbox;
use photosite::io::ply::parse;
use photosite::io::{ChangedMeshes, MissingNormals, complete};
use crate::files;

pub(crate) fn target(data: &[u8]) {
    for missing in [MissingNormals::Flat, MissingNormals::Smooth] {
        if let Ok(mut scene) = parse(data, &files().join("fuzzed.ply"), missing, &Sandbox::default()) {
            complete(&mut scene, &mut ChangedMeshes::default());
        }
    }
}
