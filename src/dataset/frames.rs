//! Frames that were planned.

use std::collections::BTreeMap;

/// Frames of a data set that were planned.
#[derive(Debug, Default)]
pub struct Frames {
    /// For each frame all changes to the capture, camera by camera.
    pub(super) changes: BTreeMap<u32, Vec<Vec<String>>>,
    /// The frames that cannot be had.
    pub(super) failed: Vec<u32>,
}

impl Frames {
    /// The numbers of those that can be made.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        self.changes.keys().copied()
    }
}
