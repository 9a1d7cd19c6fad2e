//! Frames that were planned.

use std::collections::BTreeMap;

use super::failure::Failure;

/// Frames of a data set that were planned.
#[derive(Debug, Default)]
pub struct Frames {
    /// All changes to the capture of each frame, camera by camera.
    pub(super) changes: BTreeMap<u32, Vec<Vec<String>>>,
    /// Frames that cannot be planned.
    pub(super) failed: Vec<u32>,
    /// Failures of these frames.
    pub(super) reasons: BTreeMap<u32, Failure>,
}

impl Frames {
    /// Numbers of the frames that can be made.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        self.changes.keys().copied()
    }
}
