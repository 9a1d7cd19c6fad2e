//! The library's errors as exceptions of `photosite._errors`.

use photosite::{Error, Help, Remedy};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The file of errors of values that were given in Python.
pub(crate) const PYTHON: &str = "<python>";

/// The exception for an error of the library, with its parts as attributes.
pub(crate) fn raise(py: Python<'_>, error: Error) -> PyErr {
    let is_temporary = error.is_temporary();
    // A change to a key stands in no file.
    let in_file = !matches!(&error, Error::Input(input) if input.is_override);
    let error = error.in_words(&in_arguments, "set");
    exception(py, error, is_temporary, in_file).unwrap_or_else(|failed| failed)
}

fn exception(py: Python<'_>, error: Error, is_temporary: bool, in_file: bool) -> PyResult<PyErr> {
    let text = error.to_string();
    let parts = PyDict::new(py);
    parts.set_item("is_temporary", is_temporary)?;
    let class = match error {
        Error::Temporary(inner) => return exception(py, *inner, is_temporary, in_file),
        Error::Cancelled { help, .. } => return Ok(PyKeyboardInterrupt::new_err(words(help))),
        Error::Input(input) => {
            parts.set_item("file", in_file.then_some(&input.path))?;
            parts.set_item("line", input.line)?;
            parts.set_item("key", &input.key)?;
            parts.set_item("reason", &input.message)?;
            parts.set_item("help", words(input.help))?;
            "InputError"
        }
        Error::Io { path, reason, .. } => {
            parts.set_item("file", path)?;
            parts.set_item("reason", reason.to_string())?;
            parts.set_item("errno", reason.raw_os_error())?;
            "FileError"
        }
        Error::Override { message, help, .. } | Error::Usage { message, help } => {
            parts.set_item("reason", message)?;
            parts.set_item("help", words(help))?;
            "InputError"
        }
        Error::Resources { message, help } => {
            parts.set_item("reason", message)?;
            parts.set_item("help", words(help))?;
            "ResourceError"
        }
    };
    let made = py.import("photosite._errors")?.getattr("make")?.call((class, text), Some(&parts))?;
    Ok(PyErr::from_value(made))
}

fn words(help: Option<Help>) -> Option<String> {
    help.map(|help| help.to_string())
}

/// Remedy of an error, as the arguments of functions that apply it.
pub(crate) fn in_arguments(remedy: &Remedy) -> String {
    match remedy {
        Remedy::Overwrite => "overwrite it with overwrite=True".to_owned(),
        Remedy::StartAnew => "start again with overwrite=True".to_owned(),
        Remedy::Override(change) | Remedy::Example(change) => {
            let (key, value) = change.split_once('=').unwrap_or((change, ""));
            format!("for example set={{\"{key}\": {value}}}")
        }
        Remedy::Lenient => "set={\"scene.lenient\": True} lets grey be used instead".to_owned(),
        Remedy::FilmMemory(gib) => format!("allow more with film_memory_gib={gib}"),
        Remedy::Linear => "pass linear=True if its codes are proportional to light".to_owned(),
        Remedy::LightUnit => "say what its pixel values are with unit=".to_owned(),
        Remedy::Variance(image) => {
            let argument = image.to_lowercase();
            format!("give it with variance_{argument}=; 0 if {argument} is exact")
        }
        Remedy::Moments(image) => {
            let argument = image.to_lowercase();
            format!("state how many samples per pixel its second moments come from, with samples_{argument}=")
        }
        Remedy::Say(_)
        | Remedy::Elsewhere(_)
        | Remedy::Memory(_)
        | Remedy::Samples(_)
        | Remedy::Channels(_)
        | Remedy::Masked { .. }
        | Remedy::Nearest => remedy.to_string(),
    }
}
