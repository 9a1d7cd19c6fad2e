//! `[shutter]`: when rows are exposed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When rows are exposed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShutterDescription {
    /// Left out: "global".
    #[serde(default)]
    pub kind: ShutterKind,
    /// Time from the start of one row's exposure to that of the next, µs; needed unless the shutter is global.
    pub row_time_us: Option<f64>,
}

/// Kinds of shutters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShutterKind {
    /// All rows at once.
    #[default]
    Global,
    /// Row after row from the top.
    Rolling,
    /// A single row of pixels, which records one line of the picture after the other as the camera moves (pushbroom).
    /// The second number of resolution_px counts the lines of a picture.
    Scanning,
}
