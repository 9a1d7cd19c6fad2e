//! Text of files that a user names.

use std::path::Path;

use crate::report::REPORT;
use photosite_core::{Error, Invalid, Result};
use photosite_core::{input, text};

/// The text of a capture file, a report or a sensor file.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    if path.is_dir() {
        let name = if path.join(REPORT).exists() { REPORT } else { "capture.toml" };
        let help = format!("give the capture file in it, for example {}", path.join(name).display());
        return Err(Invalid::new("", "is a folder").help(help).in_file(path));
    }
    let unreadable = |reason| Error::io(path, "read", reason);
    let is_report = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let most = if is_report { input::TABLE_BYTES } else { input::TREE_BYTES };
    let bytes = input::read_at_most(path, most).map_err(unreadable)?;
    // An image or an archive rather than a text with a wrong letter
    if text::plain(&bytes).is_ok_and(|plain| plain.contains(&0)) {
        return Err(unknown_kind(path));
    }
    text::decode(bytes).map_err(unreadable)
}

/// The error of a file that is none of those.
pub(crate) fn unknown_kind(path: &Path) -> Error {
    let invalid = Invalid::new("", "is neither TOML nor a scene of a known kind");
    invalid.help("give a capture file (.toml) or a scene (.gltf, .glb, .obj, .ply, .stl)").in_file(path)
}
