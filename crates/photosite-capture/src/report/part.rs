//! `part.json`: the provenance of the sums of a part of a render.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::traced::PlanReport;
use photosite_files::file_sum::FileSum;

/// Object that `part.json` holds.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct PartReport {
    /// First sample of every pixel, and the one after the last.
    pub samples: [u32; 2],
    /// Samples per pixel of the whole render.
    pub samples_per_pixel: u32,
    /// Input that was rendered, as a path relative to the folder of the image, or the data set file.
    pub input: String,
    /// Absolute path of the input.
    pub path: PathBuf,
    /// Changes to the capture, `key=value`.
    pub overrides: Vec<String>,
    /// Time of tracing, s; left out where the same input shall give the same bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trace_s: Option<f64>,
    /// Plan of light transport, which all parts of a render find.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<PlanReport>,
    /// File names in the folder.
    pub files: Vec<String>,
    /// Sizes and checksums of the files by their names.
    pub sums: BTreeMap<String, FileSum>,
    /// Names of the film's channels.
    pub channels: Vec<String>,
    /// Provenance that all parts of a render share beside the above: the version of photosite, the capture, hashes of
    /// its files, and their `fingerprint`.
    #[serde(flatten)]
    pub provenance: Map<String, Value>,
}

impl PartReport {
    /// Range of the samples.
    pub fn range(&self) -> Range<u32> {
        self.samples[0]..self.samples[1]
    }
}
