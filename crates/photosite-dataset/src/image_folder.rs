//! Presence of an image: its folder, and whether all files that its report lists are there as they were written.

use std::path::{Path, PathBuf};

use photosite_capture::report::{CheckDepth, REPORT, ReportFiles, damage_of_file};
use photosite_core::Error;
use photosite_files::file_sum::FileSum;
use photosite_pipeline::PART;

/// Name of an image in the manifest, CAMERA/NUMBER.
pub fn name(camera: &str, number: u32) -> String {
    format!("{camera}/{number:06}")
}

/// Folder of an image, DIR/CAMERA/NUMBER.
pub(super) fn image(folder: &Path, camera: &str, number: u32) -> PathBuf {
    folder.join(name(camera, number))
}

/// Lock of an image, which names its holder.
pub(super) fn lock(folder: &Path, camera: &str, number: u32) -> PathBuf {
    folder.join(camera).join(format!(".{number:06}.lock"))
}

/// File that states why an image could not be made.
pub(super) fn failure(folder: &Path, camera: &str, number: u32) -> PathBuf {
    folder.join(camera).join(format!(".{number:06}.failed"))
}

/// Name and damage of the first damaged file of an image.
pub(super) fn damage(folder: &Path, look: CheckDepth) -> Option<String> {
    let Some(report) = [REPORT, PART].map(|name| folder.join(name)).into_iter().find(|path| path.exists()) else {
        return Some(format!("{REPORT} is missing"));
    };
    match ReportFiles::read(&report) {
        Ok(listing) => listing.damage(folder, look),
        Err(Error::Input(error)) => Some(format!("{REPORT} {}", error.message)),
        Err(error) => Some(error.to_string()),
    }
}

/// Damage of a report whose bytes differ from the manifest's checksum.
pub(super) fn damage_of_report(folder: &Path, known: &FileSum) -> Option<String> {
    let wrong = damage_of_file(&folder.join(REPORT), Some(known), CheckDepth::Contents)?;
    Some(format!("{REPORT} {wrong}"))
}
