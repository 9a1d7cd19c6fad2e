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
    /// Where a rolling shutter begins. Left out: "from-top".
    #[serde(default)]
    pub order: RowOrder,
}

/// In which order the rows of a rolling shutter are exposed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RowOrder {
    /// One after the other from the top.
    #[default]
    FromTop,
    /// Upwards and downwards from the middle at the same time, as sensors do that are read from both sides.
    FromMiddle,
}

/// Kinds of shutters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShutterKind {
    /// All rows at once.
    #[default]
    Global,
    /// Row after row.
    Rolling,
    /// A single row of pixels, which records one line of the picture after the other as the camera moves (pushbroom).
    /// The second number of resolution_px counts the lines of a picture.
    Scanning,
}
