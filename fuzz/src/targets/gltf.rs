//! glTF and GLB files, with an animation and a variant where they have them.

use photosite::io::gltf::{Choice, Moment, read_bytes};
use photosite::io::{ChangedMeshes, complete};
use crate::files;

pub(crate) fn target(data: &[u8]) {
    let moment = Moment { animation: "move".to_owned(), start_s: 0.2, duration_s: 0.5 };
    let path = files().join(if data.starts_with(b"glTF") { "fuzzed.glb" } else { "fuzzed.gltf" });
    for choice in [Choice::default(), Choice { variant: Some("day"), moment: Some(&moment), ..Choice::default() }] {
        if let Ok(mut file) = read_bytes(data, &path, choice) {
            complete(&mut file.scene, &mut ChangedMeshes::default());
        }
    }
}
