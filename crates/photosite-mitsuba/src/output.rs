//! Output of an export: files, and differences without an exact counterpart.

use std::io::Cursor;

use super::difference::Difference;
use photosite_core::image::Planes;
use photosite_files::exr::write_exr;

/// Output gathered on the way through a capture.
#[derive(Default)]
pub(super) struct Output {
    pub(super) files: Vec<(String, Vec<u8>)>,
    pub(super) differences: Vec<Difference>,
    /// Whether the sensor is sensitive where Mitsuba's upsampling of RGB is black.
    pub(super) sees_beyond_cie: bool,
}

impl Output {
    /// Notes something that has no exact counterpart, once.
    pub(super) fn approximate(&mut self, difference: Difference) {
        if !self.differences.contains(&difference) {
            self.differences.push(difference);
        }
    }

    /// Adds a file unless it is there already, and returns its name.
    pub(super) fn file(&mut self, name: String, bytes: impl FnOnce() -> Vec<u8>) -> String {
        if !self.files.iter().any(|(existing, _)| *existing == name) {
            self.files.push((name.clone(), bytes()));
        }
        name
    }

    /// Adds an EXR image; returns its name.
    pub(super) fn exr(&mut self, name: String, planes: &Planes) -> String {
        self.file(name, || {
            let mut bytes = Vec::new();
            write_exr(planes, &[], Cursor::new(&mut bytes)).expect("a vector takes all bytes");
            bytes
        })
    }
}

/// A name for messages.
pub(super) fn quoted(kind: &str, name: &str) -> String {
    if name.is_empty() { format!("an unnamed {kind}") } else { format!("{kind} \"{name}\"") }
}
