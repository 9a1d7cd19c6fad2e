//! `part.json`: what the sums of a part of a render are sums of.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::io::file_sum::FileSum;

/// The object that `part.json` holds.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct PartReport {
    /// The first sample of every pixel, and the one after the last.
    pub samples: [u32; 2],
    /// Samples per pixel of the whole render.
    pub samples_per_pixel: u32,
    /// What was rendered, as it reads from the picture's folder or the data set file.
    pub input: String,
    /// Its path as an absolute path.
    pub path: PathBuf,
    /// Changes to the capture, `key=value`.
    pub overrides: Vec<String>,
    /// Seconds of tracing. Left out where the same input shall give the same bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trace_s: Option<f64>,
    /// File names in the folder.
    pub files: Vec<String>,
    /// Their sizes and checksums by their names.
    pub sums: BTreeMap<String, FileSum>,
    /// Names of the film's channels.
    pub channels: Vec<String>,
    /// What all parts of a render have in common beside the above: the version of photosite, the capture, hashes of its
    /// files, and their `fingerprint`.
    #[serde(flatten)]
    pub provenance: Map<String, Value>,
}

impl PartReport {
    /// The samples.
    pub fn range(&self) -> Range<u32> {
        self.samples[0]..self.samples[1]
    }
}
