//! Stored report, `capture.json`, as a capture that can be read again.

use std::path::Path;

use super::super::tree::source::CaptureSource;
use super::super::tree::text_file::read_text;
use crate::report::Report;
use photosite_core::Result;

/// A report with the text that it was read from, in which errors are placed.
#[derive(Debug)]
pub struct StoredReport {
    text: String,
    /// Contents of the report.
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
    pub fn source(&self, path: &Path) -> CaptureSource {
        let Report { capture, sensor, .. } = &self.report;
        CaptureSource::of_report(path, self.text.clone(), capture, &sensor.name)
    }
}
