//! `capture.json`: everything needed to reproduce a capture and to use its pictures. One set of types that are written
//! and read; [`report_schema`] makes a JSON Schema of them.
//!
//! Poses and intrinsics are in OpenCV's conventions: x right, y down, z forward, pixel centres at integer coordinates.

mod camera;
mod comparison;
mod exposed;
mod image;
mod lens;
mod listing;
pub(crate) mod matrix;
mod motion;
pub(crate) mod noise_words;
mod objects;
mod part;
mod pixel_pitch;
mod schema;
mod traced;
mod truth;

use std::collections::BTreeMap;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use camera::{CameraReport, FieldOfViewReport};
pub use comparison::{ComparedFile, ComparisonReport, DifferencePicture, UntestedChannels};
pub use exposed::{ExposureReport, SensorReport};
pub use image::{ImageReport, PixelGridReport};
pub use lens::{FocusStepReport, LensFiguresReport, LensReport};
pub(crate) use listing::{Listing, Look, damage_of_file};
pub use motion::{MotionReport, PathReport, PoseReport};
pub use noise_words::RenderNoise;
pub use objects::{KeypointReport, MaskReport, ObjectReport, ObjectsReport, RunLengths};
pub use part::PartReport;
pub use pixel_pitch::{pixel_pitch_m, stated_pitch_m};
pub use schema::report_schema;
pub use traced::{LightReport, NoiseReport, RenderReport};
pub use truth::{TargetReport, TruthReport};

use crate::io::file_sum::FileSum;
use crate::{Error, Invalid, Result};
use photosite_core::input;

/// The file that holds the report of a render.
pub const REPORT: &str = "capture.json";

/// The version of the schema that reports of this program have. It grows where a reader of an older version would go
/// wrong; keys that are added leave it as it is.
pub const SCHEMA_VERSION: u32 = 1;

/// The object that `capture.json` holds and `--json` prints.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct Report {
    /// [`SCHEMA_VERSION`]; 0 in reports of before there was one.
    #[serde(default)]
    pub schema_version: u32,
    /// The version of the program that wrote it.
    pub photosite_version: String,
    /// What was rendered or exposed, relative to the folder of the report.
    pub input: String,
    /// Changes to its keys, `key=value`.
    pub overrides: Vec<String>,
    /// Every key that was given: the capture file, the sensor's preset and overrides, laid over each other. With the
    /// files that it names it is a capture file again.
    pub capture: serde_json::Value,
    /// SHA-256 of all that decides the results: the version, the keys, and the files that these and the scene name. Of
    /// renders alone; none in reports of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
    /// Seed of sensor noise.
    pub seed: u64,
    /// What holds for the light, whatever sensor it falls on.
    #[serde(flatten)]
    pub traced: TracedReport,
    /// The sensor.
    pub sensor: SensorReport,
    /// The developed image; `null` where nothing is known of the lens.
    #[serde(default)]
    pub image: Option<ImageReport>,
    /// The pixels of ground truth, points and camera files; left out where nothing is known of the lens, and in reports of
    /// earlier versions, whose ground truth has all pixels of the sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pixel_grid: Option<PixelGridReport>,
    /// The exposure.
    pub exposure: ExposureReport,
    /// File names in the output folder.
    pub files: Vec<String>,
    /// Their sizes and checksums by their names; none in reports of earlier versions.
    #[serde(default)]
    pub sums: BTreeMap<String, FileSum>,
    /// What the user was warned of.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Left out where the same input shall give the same bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timings: Option<Timings>,
}

/// What holds for the light, whatever sensor it falls on. All of it is left out where nothing tells how light was
/// traced.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct TracedReport {
    /// Pose and intrinsics.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraReport>,
    /// The lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lens: Option<LensReport>,
    /// How light was traced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub render: Option<RenderReport>,
    /// What counts as white.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene_light: Option<LightReport>,
    /// Calibration targets in the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub targets: Option<Vec<TargetReport>>,
    /// Ground truth; `null` where none is written.
    #[serde(default)]
    pub truth: Option<TruthReport>,
    /// What the user was warned of that holds for the light, whatever it falls on; none in reports of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub light_warnings: Vec<String>,
    /// Camera paths traced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paths: Option<u64>,
    /// Left out where the same input shall give the same bytes.
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
