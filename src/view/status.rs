//! How far the light is: what the page hears of without asking.

use serde::Serialize;

/// What becomes of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// The scene is built.
    Preparing,
    /// Light is traced.
    Tracing,
    /// It waits to go on.
    Paused,
    /// It has been stopped; what was traced stays.
    Stopped,
    /// All samples are there.
    Done,
    /// It cannot be traced.
    Failed,
    /// It is read from files, and nothing is traced.
    Stored,
}

/// How far the light is.
#[derive(Clone, Debug, Serialize)]
pub struct Status {
    /// What becomes of it.
    pub phase: Phase,
    /// Counts the scenes and cameras that have been traced.
    pub trace: u64,
    /// Counts the lights that could be exposed; 0 while there is none.
    pub light: u64,
    /// Samples that each pixel has on average.
    pub samples_per_pixel: f64,
    /// Camera paths that are traced, and those that are expected in all.
    pub paths: u64,
    /// Paths of the whole picture.
    pub expected_paths: u64,
    /// Seconds of tracing, without pauses.
    pub elapsed_s: f64,
    /// Seconds until all is traced, where that can be said.
    pub left_s: Option<f64>,
    /// Noise of light transport over the sensor's noise, at the exposure of the capture.
    pub noise_ratio: Option<f64>,
    /// Warnings about the capture.
    pub warnings: Vec<String>,
    /// Why it has failed or stopped.
    pub message: Option<String>,
}

impl Status {
    /// Before anything is traced.
    pub(super) fn new(phase: Phase) -> Self {
        Self {
            phase,
            trace: 0,
            light: 0,
            samples_per_pixel: 0.0,
            paths: 0,
            expected_paths: 0,
            elapsed_s: 0.0,
            left_s: None,
            noise_ratio: None,
            warnings: Vec::new(),
            message: None,
        }
    }
}
