//! `capture.json` as a capture that can be read again.

use std::path::Path;

use super::source::CaptureSource;
use super::text_file::read_text;
use crate::Result;
use crate::report::Report;

/// A report with the text that it was read from, in which errors are placed.
#[derive(Debug)]
pub struct StoredReport {
    text: String,
    /// What it says.
    pub report: Report,
}

impl StoredReport {
    /// Reads `capture.json`.
    pub fn read(path: &Path) -> Result<Self> {
        let text = read_text(path)?;
        let report = Report::of_json(path, text.as_bytes())?;
        Ok(Self { text, report })
    }

    /// The values of the capture that was rendered, of a report at this path.
    pub(super) fn source(&self, path: &Path) -> CaptureSource {
        let Report { capture, sensor, .. } = &self.report;
        CaptureSource::of_report(path, self.text.clone(), capture, &sensor.name)
    }
}
