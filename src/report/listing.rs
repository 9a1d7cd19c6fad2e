//! The files that a report vouches for, and whether they are still as they were written.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

use photosite_core::input;
use serde::Deserialize;

use crate::io::file_sum::FileSum;
use crate::{Error, Invalid, Result};

/// The files that `capture.json` or `part.json` names.
#[derive(Deserialize)]
pub(crate) struct Listing {
    pub(crate) files: Vec<String>,
    /// By the files' names; none in reports of earlier versions.
    #[serde(default)]
    sums: BTreeMap<String, FileSum>,
    /// Of all that decides what they hold.
    #[serde(default)]
    pub(crate) fingerprint: Option<String>,
}

/// How closely files are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// That they are there, of the size that they had.
    Sizes,
    /// All of their bytes.
    Contents,
}

impl Listing {
    /// Reads the report at `path`, of which nothing else is looked at.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = input::read_text(path, input::TABLE_BYTES).map_err(|reason| Error::io(path, "read", reason))?;
        serde_json::from_str(&text).map_err(|e| Invalid::new("", format!("is damaged: {e}")).in_file(path))
    }

    /// The first file in the report's folder of which something is wrong: its name, and what.
    pub(crate) fn damage(&self, folder: &Path, look: Look) -> Option<String> {
        self.files.iter().find_map(|name| {
            let wrong = damage_of_file(&folder.join(name), self.sums.get(name), look)?;
            Some(format!("{name} {wrong}"))
        })
    }
}

/// What is wrong with a file of which this is known.
pub(crate) fn damage_of_file(path: &Path, known: Option<&FileSum>, look: Look) -> Option<String> {
    let found = match input::metadata(path) {
        Ok(found) => found,
        Err(reason) if reason.kind() == ErrorKind::NotFound => return Some("is missing".to_owned()),
        Err(reason) => return Some(format!("cannot be read: {reason}")),
    };
    let Some(known) = known else {
        // Reports of earlier versions state no sums.
        return (look == Look::Contents).then(|| "has no checksum to compare it with".to_owned());
    };
    if found.len() != known.bytes {
        return Some(format!("has {} bytes instead of {}", found.len(), known.bytes));
    }
    if look == Look::Sizes {
        return None;
    }
    match FileSum::of(path) {
        Ok(found) if found == *known => None,
        Ok(_) => Some("has a different checksum from when it was written".to_owned()),
        Err(reason) => Some(format!("cannot be read: {reason}")),
    }
}
