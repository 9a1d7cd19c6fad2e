//! The command line.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command with its arguments, of which the first is its name, and returns its exit status.
#[pyfunction]
#[pyo3(signature = (arguments, /))]
pub(crate) fn cli(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| photosite_cli::run(arguments))
}
