//! Data set files, and what their first frames are.

use photosite::Sandbox;
use photosite::capture::DatasetFile;
use photosite::dataset::DataSet;
use photosite::pipeline::{FilmMemory, Silent};
use crate::written;

pub(crate) fn target(data: &[u8]) {
    let path = written("dataset.toml", data);
    let set =
        DatasetFile::read(&path).and_then(|file| DataSet::new(&Sandbox::default(), file, &[], FilmMemory::default()));
    if let Ok(set) = set {
        let _ = set.frames(0..2, false, &Silent);
    }
}
