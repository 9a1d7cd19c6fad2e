//! `manifest.jsonl`, the list of the images of a data set.

use photosite::dataset::read_dataset;
use crate::{folder, written};

pub(crate) fn target(data: &[u8]) {
    written("manifest.jsonl", data);
    let _ = read_dataset(folder());
}
