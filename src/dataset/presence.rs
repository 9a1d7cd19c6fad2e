//! Where a picture of a data set is, and whether it is there: all files that its report lists, as they were written.

use std::path::{Path, PathBuf};

use crate::Error;
use crate::io::file_sum::FileSum;
use crate::pipeline::PART;
use crate::report::{Listing, Look, REPORT, damage_of_file};

/// CAMERA/NUMBER, as the manifest has it.
pub fn name(camera: &str, number: u32) -> String {
    format!("{camera}/{number:06}")
}

/// DIR/CAMERA/NUMBER.
pub(super) fn picture(folder: &Path, camera: &str, number: u32) -> PathBuf {
    folder.join(name(camera, number))
}

/// What is wrong with the first file of a picture of which something is: its name, and what.
pub(super) fn damage(folder: &Path, look: Look) -> Option<String> {
    let Some(report) = [REPORT, PART].map(|name| folder.join(name)).into_iter().find(|path| path.exists()) else {
        return Some(format!("{REPORT} is missing"));
    };
    match Listing::read(&report) {
        Ok(listing) => listing.damage(folder, look),
        Err(Error::Input(error)) => Some(format!("{REPORT} {}", error.message)),
        Err(error) => Some(error.to_string()),
    }
}

/// Whether a report has the bytes that the manifest states of it.
pub(super) fn damage_of_report(folder: &Path, known: &FileSum) -> Option<String> {
    let wrong = damage_of_file(&folder.join(REPORT), Some(known), Look::Contents)?;
    Some(format!("{REPORT} {wrong}"))
}
