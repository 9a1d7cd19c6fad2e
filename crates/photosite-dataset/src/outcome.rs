//! Outcome of a run over a data set.

use super::folder::DatasetFolder;
use super::selection::FrameList;
use photosite_core::{Invalid, Result};

/// Outcome of a run over a data set.
#[derive(Debug, Default)]
pub struct DatasetOutcome {
    /// Number of images made by this process.
    pub images: usize,
    /// Frames that could not be made, in order.
    pub failed: Vec<u32>,
    /// Whether another attempt may make some of the failed images.
    pub may_pass: bool,
}

impl DatasetOutcome {
    /// Error if some frames could not be made.
    pub fn check(&self, folder: &DatasetFolder) -> Result<()> {
        if self.failed.is_empty() {
            return Ok(());
        }
        let frames = FrameList::of(&self.failed);
        let message = format!("lacks frames that could not be made: {frames}");
        let help = format!("see the messages about each, and then give the same command with --frames {frames}");
        let error = Invalid::new("", message).help(help).in_file(folder.path());
        Err(if self.may_pass { error.temporary() } else { error })
    }
}
