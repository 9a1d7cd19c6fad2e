//! Captures for Python.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;

use crate::error::raise;
use crate::work::{How, work};

/// A capture that is loaded and checked.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Capture(Arc<photosite::Capture>);

impl Capture {
    pub(crate) fn capture(&self) -> &Arc<photosite::Capture> {
        &self.0
    }
}

#[pymethods]
impl Capture {
    /// Loads a capture file, a report or a scene file, with changes to its keys, `key=value`.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        let loaded = work(py, How::default(), |_| photosite::Capture::load_with(&path, &overrides))?;
        Ok(Self(Arc::new(loaded)))
    }

    /// Reads the values of a capture file, given as JSON; `path` stands for the file.
    #[staticmethod]
    fn of_values(py: Python<'_>, values: &str, path: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        let loaded = work(py, How::default(), |_| {
            let values = serde_json::from_str(values)
                .map_err(|reason| photosite::Invalid::new("", reason.to_string()).in_file(&path))?;
            photosite::Capture::of_values(&values, &path, &overrides)
        })?;
        Ok(Self(Arc::new(loaded)))
    }

    /// The capture with more changes.
    fn changed(&self, py: Python<'_>, overrides: Vec<String>) -> PyResult<Self> {
        let capture = &self.0;
        Ok(Self(Arc::new(work(py, How::default(), |_| capture.with(&overrides))?)))
    }

    /// Columns and rows of the sensor.
    fn resolution(&self) -> [usize; 2] {
        self.0.sensor().resolution
    }

    /// Number of frames that the capture asks for, and whether each needs light of its own.
    fn series(&self) -> (u32, bool) {
        (self.0.exposure().frames, self.0.recording().is_some())
    }

    /// Values of all keys that were given, as JSON; paths are relative to a folder.
    fn values(&self, py: Python<'_>, folder: PathBuf) -> PyResult<String> {
        let values = self.0.to_json(Path::new(&folder)).map_err(|error| raise(py, error))?;
        Ok(values.to_string())
    }
}
