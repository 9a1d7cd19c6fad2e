//! What commands say of files whose numbers they take as they are.

use std::path::Path;

use super::log::warning;
use crate::Result;
use crate::io::picture_notes::PictureNotes;

/// Warns of what the files of pictures say that their numbers alone do not tell.
pub(super) fn warn_of<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    for path in paths {
        PictureNotes::read(path)?.of_numbers(path).iter().for_each(|what| warning!("{what}"));
    }
    Ok(())
}
