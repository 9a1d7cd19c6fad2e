//! Data set files, with the errors of capture files: every one names the file, the key and its line.

use std::path::{Path, PathBuf};

use super::super::tables::file_kind::FileKind;
use super::super::tree::source::CaptureSource;
use super::super::tree::source::shown;
use super::super::tree::text_file::read_text;
use photosite_calibration::dataset::DatasetDescription;
use photosite_core::{Error, Invalid, Result};

/// A data set file as read.
#[derive(Debug)]
pub struct DatasetFile {
    /// Description of the data set.
    pub description: DatasetDescription,
    /// The description as JSON, without comments and order.
    pub values: serde_json::Value,
    source: CaptureSource,
}

impl DatasetFile {
    /// Path of the file that it was read from.
    pub fn path(&self) -> &Path {
        self.source.path()
    }

    /// The capture that all frames are made from.
    pub fn capture(&self) -> PathBuf {
        self.path().parent().unwrap_or(Path::new("")).join(&self.description.capture)
    }

    /// Reads a data set file.
    pub fn read(path: &Path) -> Result<Self> {
        if path.is_dir() {
            let help = "give the data set file (.toml) that it is made from";
            return Err(Invalid::new("", "is a folder").help(help).in_file(path));
        }
        if let Some(kind) = FileKind::of_name(path).filter(|_| path.is_file()) {
            return Err(kind.instead_of("a data set file", path));
        }
        let source = CaptureSource::parse(path, read_text(path)?)?;
        match FileKind::of_keys(source.sections().map(|(key, _)| key)) {
            Some(kind) if kind != FileKind::DataSet => return Err(kind.instead_of("a data set file", path)),
            Some(_) | None => {}
        }
        if !source.has("capture") {
            let help = "for example capture = \"capture.toml\"";
            return Err(source.error(Invalid::new("", "the key `capture` is missing").help(help)));
        }
        Ok(Self { description: source.read_whole()?, values: source.read_whole()?, source })
    }

    /// The error of a change that this file makes to the capture of a camera, at the key that asks for it, with the
    /// frame where the change is that of one. Other errors stay as they are.
    pub fn error_of_change(&self, error: Error, camera: &str, frame: Option<u32>, changes: &[String]) -> Error {
        let argument = match &error {
            Error::Input(error) if error.is_override => error.path.to_string_lossy().into_owned(),
            Error::Override { argument, .. } => argument.clone(),
            Error::Input(_)
            | Error::Io { .. }
            | Error::Usage { .. }
            | Error::Resources { .. }
            | Error::Temporary(_)
            | Error::Cancelled { .. } => {
                return error;
            }
        };
        let index = self.description.cameras.iter().position(|other| other.name == camera).unwrap_or(0);
        let change = changes.iter().rev().find(|change| shown(change) == argument);
        let Some(key) = change.and_then(|change| self.description.key_of(index, change)) else { return error };
        let (message, help) = match error {
            Error::Input(error) => (format!("{}: {}", error.key, error.message), error.help),
            Error::Override { message, help, .. } => (message, help),
            Error::Io { .. }
            | Error::Usage { .. }
            | Error::Resources { .. }
            | Error::Temporary(_)
            | Error::Cancelled { .. } => return error,
        };
        // A file has no options.
        let help = help.map(|help| help.to_string().into());
        let frame = frame.map(|frame| format!("in frame {frame}")).into_iter();
        let camera = (!self.description.cameras.is_empty()).then(|| format!("of camera {camera}"));
        let place: String = frame.chain(camera).map(|part| part + " ").collect();
        let place = if place.is_empty() { place } else { format!("{}: ", place.trim_end()) };
        self.error(Invalid { key, message: place + &message, help })
    }

    /// An error that shows up later, at its line.
    pub fn error(&self, invalid: Invalid) -> Error {
        self.source.error(invalid)
    }
}
