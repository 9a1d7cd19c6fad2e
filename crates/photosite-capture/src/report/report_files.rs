//! Files that a report vouches for, and checks of whether they are still as they were written.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

use photosite_core::input;
use serde::Deserialize;

use photosite_core::{Error, Invalid, Result};
use photosite_files::file_sum::FileSum;

/// Files that `capture.json` or `part.json` names.
#[derive(Deserialize)]
pub struct ReportFiles {
    /// Names of files beside the report.
    pub files: Vec<String>,
    /// Checksums by the files' names; none in reports of earlier versions.
    #[serde(default)]
    sums: BTreeMap<String, FileSum>,
    /// Fingerprint of everything that decides the content of the files.
    #[serde(default)]
    pub fingerprint: Option<String>,
}

/// Depth of a check of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckDepth {
    /// Existence and size.
    Sizes,
    /// All bytes.
    Contents,
}

impl ReportFiles {
    /// Reads the list of files in the report at `path`.
    pub fn read(path: &Path) -> Result<Self> {
        let text = input::read_text(path, input::TABLE_BYTES).map_err(|reason| Error::io(path, "read", reason))?;
        serde_json::from_str(&text).map_err(|e| Invalid::new("", format!("is damaged: {e}")).in_file(path))
    }

    /// Name and damage of the first damaged file in the report's folder.
    pub fn damage(&self, folder: &Path, look: CheckDepth) -> Option<String> {
        self.files.iter().find_map(|name| {
            let wrong = damage_of_file(&folder.join(name), self.sums.get(name), look)?;
            Some(format!("{name} {wrong}"))
        })
    }
}

/// Damage of a file with this known checksum.
pub fn damage_of_file(path: &Path, known: Option<&FileSum>, look: CheckDepth) -> Option<String> {
    let found = match input::metadata(path) {
        Ok(found) => found,
        Err(reason) if reason.kind() == ErrorKind::NotFound => return Some("is missing".to_owned()),
        Err(reason) => return Some(format!("cannot be read: {reason}")),
    };
    let Some(known) = known else {
        // Reports of earlier versions state no sums.
        return (look == CheckDepth::Contents).then(|| "has no checksum to compare it with".to_owned());
    };
    if found.len() != known.bytes {
        return Some(format!("has {} bytes instead of {}", found.len(), known.bytes));
    }
    if look == CheckDepth::Sizes {
        return None;
    }
    match FileSum::of(path) {
        Ok(found) if found == *known => None,
        Ok(_) => Some("has a different checksum from when it was written".to_owned()),
        Err(reason) => Some(format!("cannot be read: {reason}")),
    }
}
