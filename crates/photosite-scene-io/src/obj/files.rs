//! Files of OBJ scenes, and references between them.

use std::path::{Path, PathBuf};

use photosite_core::{Error, Result, input, text};

/// Reads a text in any encoding.
pub(super) fn read_text(path: &Path) -> Result<String> {
    let text = input::read(path).and_then(text::decode_any);
    text.map_err(|reason| Error::io(path, "read", reason))
}

/// Path of a file that another one names; backslashes of other systems are accepted where nothing else matches.
pub(super) fn file_beside(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    if path.exists() || !name.contains('\\') { path } else { folder.join(name.replace('\\', "/")) }
}
