//! `capture.json`: everything needed to reproduce a capture and to use its images. One set of types is both written and
//! read; [`report_schema`] makes a JSON Schema of it.
//!
//! Poses and intrinsics are in OpenCV's conventions: x right, y down, z forward, pixel centres at integer coordinates.

mod camera;
mod comparison;
mod exposed;
mod image;
mod lens;
pub mod matrix;
mod motion;
pub mod noise_words;
mod objects;
mod part;
mod pixel_pitch;
mod report_files;
mod schema;
mod traced;
mod truth;

use std::collections::BTreeMap;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use camera::{CameraReport, FieldOfViewReport};
pub use comparison::{ComparedFile, ComparisonReport, DifferenceImage, UntestedChannels};
pub use exposed::{ExposureReport, SensorReport};
pub use image::{ImageReport, PixelGridReport};
pub use lens::{FocusStepReport, LensFiguresReport, LensReport};
pub use motion::{MotionReport, PathReport, PoseReport};
pub use noise_words::RenderNoise;
pub use objects::{KeypointReport, MaskReport, ObjectReport, ObjectsReport, RunLengths};
pub use part::PartReport;
pub use pixel_pitch::{pixel_pitch_m, stated_pitch_m};
pub use report_files::{CheckDepth, ReportFiles, damage_of_file};
pub use schema::report_schema;
pub use traced::{LightReport, NoiseReport, PlanReport, RenderReport};
pub use truth::{TargetReport, TruthReport};

use photosite_core::input;
use photosite_core::{Error, Invalid, Result};
use photosite_files::file_sum::FileSum;

/// Name of the file of a render's report.
pub const REPORT: &str = "capture.json";

/// Version of the schema of this program's reports. It grows where a reader of an older version would go wrong; added
/// keys leave it as it is.
pub const SCHEMA_VERSION: u32 = 1;

/// Object that `capture.json` holds and `--json` prints.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct Report {
    /// Version of the schema, [`SCHEMA_VERSION`]; 0 in reports from before there was one.
    #[serde(default)]
    pub schema_version: u32,
    /// Version of the program that wrote the report.
    pub photosite_version: String,
    /// Input that was rendered or exposed, relative to the folder of the report.
    pub input: String,
    /// Changes to the keys of the input, `key=value`.
    pub overrides: Vec<String>,
    /// Every key that was given: the capture file, the sensor's preset and overrides, laid over each other. With the
    /// files that it names it is a capture file again.
    pub capture: serde_json::Value,
    /// SHA-256 of everything that decides the results: the version, the keys, and the files that these and the scene
    /// name. For renders alone; none in reports of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
    /// Seed of sensor noise.
    pub seed: u64,
    /// Entries on the light, which hold whatever sensor it falls on.
    #[serde(flatten)]
    pub traced: TracedReport,
    /// The sensor.
    pub sensor: SensorReport,
    /// The developed image; `null` where nothing is known of the lens.
    #[serde(default)]
    pub image: Option<ImageReport>,
    /// Pixels of ground truth, points and camera files; left out where nothing is known of the lens, and in reports of
    /// earlier versions, whose ground truth has all pixels of the sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pixel_grid: Option<PixelGridReport>,
    /// The exposure.
    pub exposure: ExposureReport,
    /// File names in the output folder.
    pub files: Vec<String>,
    /// Sizes and checksums of the files by their names; none in reports of earlier versions.
    #[serde(default)]
    pub sums: BTreeMap<String, FileSum>,
    /// Warnings that the user got.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Timings of the steps; left out where the same input shall give the same bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timings: Option<Timings>,
}

/// Entries on the light, which hold whatever sensor it falls on. All of them are left out where nothing tells how light
/// was traced.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct TracedReport {
    /// Pose and intrinsics of the camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraReport>,
    /// The lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lens: Option<LensReport>,
    /// Settings and results of tracing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub render: Option<RenderReport>,
    /// Light that counts as white.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene_light: Option<LightReport>,
    /// Calibration targets in the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub targets: Option<Vec<TargetReport>>,
    /// Ground truth; `null` where none is written.
    #[serde(default)]
    pub truth: Option<TruthReport>,
    /// Warnings about the light, which hold whatever sensor it falls on; none in reports of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub light_warnings: Vec<String>,
    /// Camera paths traced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paths: Option<u64>,
    /// Camera paths traced per second; left out where the same input shall give the same bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paths_per_s: Option<f64>,
}

/// Wall-clock seconds of the steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct Timings {
    /// Reading the capture and its files.
    pub load_s: f64,
    /// Building the scene.
    pub build_s: f64,
    /// Tracing.
    pub trace_s: f64,
    /// Exposing.
    pub expose_s: f64,
    /// Developing.
    pub develop_s: f64,
    /// Writing.
    pub write_s: f64,
}

impl Report {
    /// Reads a report.
    ///
    /// # Errors
    ///
    /// A file that is missing, is none, or is of a version that this program does not know.
    pub fn read(path: &Path) -> Result<Self> {
        let text = input::read_text(path, input::TABLE_BYTES).map_err(|reason| Error::io(path, "read", reason))?;
        Self::of_json(path, text.as_bytes())
    }

    /// Reads a report from memory; `path` is for messages.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read), but for files that are missing.
    pub fn of_json(path: &Path, bytes: &[u8]) -> Result<Self> {
        let report: Self = serde_json::from_slice(bytes).map_err(|error| {
            let is_other = |value: serde_json::Value| !value.get("capture").is_some_and(serde_json::Value::is_object);
            let message = if serde_json::from_slice(bytes).is_ok_and(is_other) {
                "is not a report of a render: it holds no capture".to_owned()
            } else {
                format!("is damaged: {error}")
            };
            Invalid::new("", message).help("give a file that photosite render wrote").in_file(path)
        })?;
        if report.schema_version > SCHEMA_VERSION {
            let message = format!("is of version {}, and this program knows {SCHEMA_VERSION}", report.schema_version);
            let help = format!("use photosite {} or later", report.photosite_version);
            return Err(Invalid::new("schema_version", message).help(help).in_file(path));
        }
        Ok(report)
    }
}
