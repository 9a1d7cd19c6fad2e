//! Status of the light, which the page hears of without asking.

use serde::Serialize;

use photosite_pipeline::Prepared;
use photosite_transport::optics::Camera;

/// Phase of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// Preparation: the scene is built.
    Preparing,
    /// Tracing under way.
    Tracing,
    /// Tracing that waits to go on.
    Paused,
    /// Tracing that was stopped; the light traced so far stays.
    Stopped,
    /// Light with all of its samples.
    Done,
    /// Light that cannot be traced.
    Failed,
    /// Light that is read from files; nothing is traced.
    Stored,
}

/// Pose of a camera, and its lens.
#[derive(Clone, Debug, Serialize)]
pub struct CameraState {
    /// The centre of the lens in the world, m.
    pub position_m: [f64; 3],
    /// Direction to the right in the world.
    pub right: [f64; 3],
    /// Direction up in the world, opposite to `down` of OpenCV's camera.
    pub up: [f64; 3],
    /// Direction along the optical axis in the world.
    pub forward: [f64; 3],
    /// Focus distance, m; `None` at infinity, and of lenses without focus.
    pub focus_distance_m: Option<f64>,
    /// Distance, m, of the surface in the middle of the image, around which the camera turns.
    pub pivot_m: f64,
    /// Focal length, mm.
    pub focal_length_mm: f64,
    /// Whether the camera moves while light is traced, and so cannot be placed by the page.
    pub moves: bool,
}

impl CameraState {
    pub(super) fn new(prepared: &Prepared) -> Option<Self> {
        let camera = prepared.camera();
        let capture = prepared.capture();
        if !camera.makes_image() {
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
            focal_length_mm: capture.lens().focal_length_m * 1e3,
            moves: camera.moves(),
        })
    }
}

/// Distance, m, of the surface in the middle of the image.
fn distance_ahead_m(prepared: &Prepared, camera: &Camera) -> Option<f64> {
    let middle = prepared.resolution().map(|n| f64::from(n) / 2.0);
    let hit = prepared.scene().closest(&camera.chief_ray(middle.into())?)?;
    Some(f64::from(hit.t)).filter(|distance| distance.is_finite() && *distance > 0.0)
}

/// Status of the light.
#[derive(Clone, Debug, Serialize)]
pub struct Status {
    /// Phase of the light.
    pub phase: Phase,
    /// Number of scenes and cameras that have been traced.
    pub trace: u64,
    /// Number of lights that could be exposed; 0 while there is none.
    pub light: u64,
    /// Samples that each pixel has on average.
    pub samples_per_pixel: f64,
    /// Number of camera paths that are traced.
    pub paths: u64,
    /// Number of paths of the whole image.
    pub expected_paths: u64,
    /// Seconds of tracing, without pauses.
    pub elapsed_s: f64,
    /// Seconds until all is traced, where that can be said.
    pub left_s: Option<f64>,
    /// The number of the frame, where camera or scene move and so each has light of its own.
    pub frame: Option<u32>,
    /// Pose of the camera, and its lens.
    pub camera: Option<CameraState>,
    /// Warnings about the capture.
    pub warnings: Vec<String>,
    /// Reason why tracing has failed or stopped.
    pub message: Option<String>,
}

impl Status {
    /// Status before anything is traced.
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
