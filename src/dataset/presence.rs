//! Where a picture of a data set is, and whether it is there: all files that its report lists, as they were written.

use std::fs;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::io::file_sum::FileSum;
use crate::pipeline::PART;
use crate::report::{Listing, REPORT};

/// DIR/CAMERA/NUMBER.
pub(super) fn picture(folder: &Path, camera: &str, number: u32) -> PathBuf {
    folder.join(camera).join(format!("{number:06}"))
}

/// How closely files are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// That they are there, of the size that they had.
    Sizes,
    /// All of their bytes.
    Contents,
}

/// What is wrong with the first file of a picture of which something is: its name, and what.
pub(super) fn damage(folder: &Path, look: Look) -> Option<String> {
    let Some(report) = [REPORT, PART].map(|name| folder.join(name)).into_iter().find(|path| path.exists()) else {
        return Some(format!("{REPORT} is missing"));
    };
    let Listing { files, sums } = match Listing::read(&report) {
        Ok(listing) => listing,
        Err(Error::Input(error)) => return Some(format!("{REPORT} {}", error.message)),
        Err(error) => return Some(error.to_string()),
    };
    files.iter().find_map(|name| {
        let wrong = damage_of_file(&folder.join(name), sums.get(name), look)?;
        Some(format!("{name} {wrong}"))
    })
}

fn damage_of_file(path: &Path, known: Option<&FileSum>, look: Look) -> Option<String> {
    let Ok(found) = fs::metadata(path) else { return Some("is missing".to_owned()) };
    let Some(known) = known else {
        // Reports of earlier versions state no sums.
        return (look == Look::Contents).then(|| "has no checksum that it could be held against".to_owned());
    };
    if found.len() != known.bytes {
        return Some(format!("has {} bytes instead of {}", found.len(), known.bytes));
    }
    if look == Look::Sizes {
        return None;
    }
    match FileSum::of(path) {
        Ok(found) if found == *known => None,
        Ok(_) => Some("has another checksum than when it was written".to_owned()),
        Err(reason) => Some(format!("cannot be read: {reason}")),
    }
}

/// Whether a report has the bytes that the manifest states of it.
pub(super) fn damage_of_report(folder: &Path, known: &FileSum) -> Option<String> {
    let wrong = damage_of_file(&folder.join(REPORT), Some(known), Look::Contents)?;
    Some(format!("{REPORT} {wrong}"))
}
