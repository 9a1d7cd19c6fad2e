//! What has become of the pictures of a data set.

use super::folder::DatasetFolder;
use super::selection::FrameList;
use crate::{Invalid, Result};

/// What a run has made of a data set.
#[derive(Debug, Default)]
pub struct Made {
    /// How many pictures, by this process.
    pub pictures: usize,
    /// The frames that could not be made, in order.
    pub failed: Vec<u32>,
    /// Whether another try may make some of them.
    pub may_pass: bool,
}

impl Made {
    /// Refuses to call it done where frames are bad.
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
