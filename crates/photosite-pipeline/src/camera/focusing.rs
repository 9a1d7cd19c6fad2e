//! The camera of a capture in its place, focused on what its autofocus finds.

use std::cell::OnceCell;

use glam::DAffine3;

use super::autofocus;
use super::capture_camera::camera_of;
use super::film_responses::{importance, responses};
use photosite_capture::Capture;
use photosite_capture::report::FocusStepReport;
use photosite_core::projection::Projection;
use photosite_core::{Invalid, Result};
use photosite_transport::optics::{AutofocusMethod, Camera, Focus, LensDescription, LensKind};
use photosite_transport::scene::description::SceneDescription;
use photosite_transport::scene::{self, Scene};

/// A camera in its place, focused.
pub(crate) struct FocusedCamera {
    pub(crate) camera: Camera,
    /// Places that autofocus by contrast has tried.
    pub(crate) steps: Vec<FocusStepReport>,
    /// Whether autofocus has found no sharper focus than the nearest that the lens has.
    pub(crate) is_nearest: bool,
}

/// The camera of a capture in its place, focused on what autofocus finds in the scene, which is asked for then only.
pub fn place_camera<'a>(capture: &Capture, scene: impl Fn() -> &'a Scene) -> Result<Camera> {
    focus_camera(capture, capture.camera_to_world(), scene).map(|focused| focused.camera)
}

/// The camera of a capture at a pose, focused in the same way.
pub(crate) fn focus_camera<'a>(
    capture: &Capture,
    to_world: DAffine3,
    scene: impl Fn() -> &'a Scene,
) -> Result<FocusedCamera> {
    let place = |lens: &_, distance| {
        let camera = camera_of(lens, capture.sensor(), to_world, distance);
        camera.map_err(|invalid| capture.source().error(invalid.within("lens")))
    };
    let with_sensor_at = |v: f64| LensDescription { focus: Focus::ImageDistance(v), ..capture.lens().clone() };
    let (mut steps, mut is_nearest) = (Vec::new(), false);
    let camera = match capture.lens().focus {
        Focus::Autofocus { pixel, method: AutofocusMethod::Exact } => {
            // Focusing moves the sensor and with it the direction of the chief ray; a few rounds settle it.
            let unfocused = match capture.lens().kind {
                LensKind::Prescription => LensDescription { focus: Focus::Infinity, ..capture.lens().clone() },
                LensKind::Thin | LensKind::Pinhole | LensKind::Hole | LensKind::Bare => {
                    with_sensor_at(capture.lens().focal_length_m.abs())
                }
            };
            let mut camera = place(&unfocused, f64::NAN)?;
            for _ in 0..4 {
                let hit = camera.chief_ray(pixel.into()).and_then(|ray| scene().closest(&ray));
                camera = place(capture.lens(), hit.map_or(f64::INFINITY, |hit| f64::from(hit.t)))?;
            }
            camera
        }
        Focus::Autofocus { pixel, method: AutofocusMethod::Contrast(how) } => {
            let search = autofocus::search(capture, to_world, scene(), pixel, &how)?;
            (steps, is_nearest) = (search.steps, search.is_nearest);
            place(&with_sensor_at(search.image_distance_m), f64::NAN)?
        }
        Focus::Distance(_) | Focus::Infinity | Focus::ImageDistance(_) => place(capture.lens(), f64::NAN)?,
    };
    match camera.check_coverage() {
        Ok(()) => Ok(FocusedCamera { camera, steps, is_nearest }),
        Err(invalid) => {
            // A lens without distortion ends where its focal length lets it.
            let is_ideal = capture.lens().projection == Projection::Perspective;
            let key = match capture.lens().intrinsics {
                _ if !is_ideal => invalid.key,
                Some(_) => "intrinsics".to_owned(),
                None => "focal_length_mm".to_owned(),
            };
            let invalid = Invalid { key, ..invalid };
            Err(capture.source().error(invalid.within("lens")))
        }
    }
}

/// The camera of a capture that is not rendered: its scene is built only where autofocus has to look at it.
pub fn standalone_camera(capture: &Capture) -> Result<Camera> {
    let built = OnceCell::new();
    let build = || scene::build(SceneDescription::clone(capture.scene()), &importance(&responses(capture)));
    place_camera(capture, || built.get_or_init(build))
}

/// Places the camera of a capture that is not rendered, as it takes the capture's first image.
pub fn standalone_recording_camera(capture: &Capture) -> Result<Camera> {
    let camera = standalone_camera(capture)?;
    Ok(match capture.recording() {
        Some(recording) => camera.recording(recording.clone()),
        None => camera,
    })
}
