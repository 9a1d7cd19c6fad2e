//! How far the light is: what the page hears of without asking.

use serde::Serialize;

use crate::optics::Camera;
use crate::pipeline::Prepared;

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

/// Where a camera stands, and its lens.
#[derive(Clone, Debug, Serialize)]
pub struct CameraState {
    /// The centre of the lens in the world, m.
    pub position_m: [f64; 3],
    /// Directions in the world.
    pub right: [f64; 3],
    /// Against `down` of OpenCV's camera.
    pub up: [f64; 3],
    /// Along the axis.
    pub forward: [f64; 3],
    /// Distance at which it is focused; `None` at infinity, and of lenses without focus.
    pub focus_distance_m: Option<f64>,
    /// Distance of what the middle of the picture shows, around which the camera turns.
    pub pivot_m: f64,
    /// Focal length, mm.
    pub focal_length_mm: f64,
    /// Whether it moves while light is traced, and so cannot be placed by the page.
    pub moves: bool,
}

impl CameraState {
    pub(super) fn new(prepared: &Prepared) -> Option<Self> {
        let camera = prepared.camera();
        let capture = prepared.capture();
        if !camera.makes_picture() {
            return None;
        }
        let focus = camera.focus_distance_m();
        let report = prepared.camera_report();
        let [right, down, forward] = report.rotation;
        Some(Self {
            position_m: report.position_m,
            right,
            up: down.map(|x| -x),
            forward,
            focus_distance_m: (focus.is_finite() && focus > 0.0).then_some(focus),
            pivot_m: distance_ahead_m(prepared, &camera).unwrap_or(1.0),
            focal_length_mm: capture.lens.focal_length_m * 1e3,
            moves: camera.moves(),
        })
    }
}

/// Distance along the axis of what the middle of the picture shows.
fn distance_ahead_m(prepared: &Prepared, camera: &Camera) -> Option<f64> {
    let middle = prepared.resolution().map(|n| f64::from(n) / 2.0);
    let hit = prepared.scene().closest(&camera.chief_ray(middle.into())?)?;
    Some(f64::from(hit.t)).filter(|distance| distance.is_finite() && *distance > 0.0)
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
    /// The number of the frame, where camera or scene move and so each has light of its own.
    pub frame: Option<u32>,
    /// Where the camera stands, and its lens.
    pub camera: Option<CameraState>,
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
            frame: None,
            camera: None,
            warnings: Vec::new(),
            message: None,
        }
    }
}
