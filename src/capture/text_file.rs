//! Text of files that a user names.

use std::fs;
use std::path::Path;

use crate::report::REPORT;
use crate::{Error, Invalid, Result};

/// The text of a capture file, a report or a sensor file.
pub(super) fn read_text(path: &Path) -> Result<String> {
    if path.is_dir() {
        let name = if path.join(REPORT).exists() { REPORT } else { "capture.toml" };
        let help = format!("give the capture file in it, for example {}", path.join(name).display());
        return Err(Invalid::new("", "is a folder").help(help).in_file(path));
    }
    let bytes = fs::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    String::from_utf8(bytes).map_err(|_| unknown_kind(path))
}

/// The error of a file that is none of those.
pub(super) fn unknown_kind(path: &Path) -> Error {
    let invalid = Invalid::new("", "is neither TOML nor a scene of a known kind");
    invalid.help("give a capture file (.toml) or a scene (.gltf, .glb, .obj)").in_file(path)
}
