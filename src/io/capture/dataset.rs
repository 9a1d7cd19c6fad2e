//! Data set files, with the errors of capture files: every one names the file, the key and its line.

use std::path::Path;

use super::read_text;
use super::source::CaptureSource;
use crate::calibration::dataset::DatasetDescription;
use crate::{Error, Invalid, Result};

/// A data set file as read.
#[derive(Debug)]
pub struct DatasetFile {
    /// What it says.
    pub description: DatasetDescription,
    /// The same as JSON, without comments and order.
    pub values: serde_json::Value,
    source: CaptureSource,
}

impl DatasetFile {
    /// Reads a data set file.
    pub fn read(path: &Path) -> Result<Self> {
        let source = CaptureSource::parse(path, read_text(path)?)?;
        if !source.has("capture") {
            let help = "for example capture = \"capture.toml\"";
            return Err(source.error(Invalid::new("", "the key `capture` is missing").help(help)));
        }
        Ok(Self { description: source.read_whole()?, values: source.read_whole()?, source })
    }

    /// An error that shows up later, at its line.
    pub fn error(&self, invalid: Invalid) -> Error {
        self.source.error(invalid)
    }
}
