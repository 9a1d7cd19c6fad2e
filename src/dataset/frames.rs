//! Frames that were planned.

use std::collections::BTreeMap;

use super::failure::Failure;

/// Frames of a data set that were planned.
#[derive(Debug, Default)]
pub struct Frames {
    /// For each frame all changes to the capture, camera by camera.
    pub(super) changes: BTreeMap<u32, Vec<Vec<String>>>,
    /// The frames that cannot be had.
    pub(super) failed: Vec<u32>,
    /// Why not.
    pub(super) reasons: BTreeMap<u32, Failure>,
}

impl Frames {
    /// The numbers of those that can be made.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        self.changes.keys().copied()
    }
}
