//! Text files and the names by which they refer to each other.

use std::path::{Path, PathBuf};

use photosite_core::input;
use photosite_core::{Error, Result};

/// Bytes that are no UTF-8, as in comments and names of old files, become replacement characters.
pub(super) fn read_text(path: &Path) -> Result<String> {
    let bytes = input::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    Ok(String::from_utf8(bytes).unwrap_or_else(|bad| String::from_utf8_lossy(bad.as_bytes()).into_owned()))
}

/// The path of a file that another one names; backslashes of other systems are understood where nothing else fits.
pub(super) fn file_beside(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    if path.exists() || !name.contains('\\') { path } else { folder.join(name.replace('\\', "/")) }
}
