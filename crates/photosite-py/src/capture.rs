//! Captures.

use std::path::PathBuf;

use pyo3::prelude::*;

use crate::work::{How, work};

/// A capture that is loaded and checked.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Capture(pub(crate) photosite::Capture);

#[pymethods]
impl Capture {
    /// Loads a capture file, a report or a scene file, with changes to its keys, `key=value`.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        work(py, How::default(), |_| photosite::Capture::load_with(&path, &overrides)).map(Self)
    }
}
