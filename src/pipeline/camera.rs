//! The camera that lens, sensor and pose of a capture make.

use std::cell::OnceCell;

use glam::DAffine3;

use super::responses::{importance, responses};
use crate::capture::Capture;
use crate::geometry::{Hit, Ray};
use crate::optics::{Camera, Focus, LensDescription, PixelGrid};
use crate::sensor::SensorModel;
use crate::{Invalid, Result, scene};

/// Columns and rows of the picture.
pub fn pixels(capture: &Capture) -> [u32; 2] {
    in_u32(capture.sensor.resolution)
}

fn in_u32(resolution: [usize; 2]) -> [u32; 2] {
    resolution.map(|n| u32::try_from(n).expect("resolutions are checked when they are read"))
}

/// The camera that lens and sensor make.
pub fn camera_of(
    lens: &LensDescription,
    sensor: &SensorModel,
    to_world: DAffine3,
    autofocus_distance_m: f64,
) -> Result<Camera, Invalid> {
    let grid = PixelGrid { resolution: in_u32(sensor.pixel_array()), pitch_m: sensor.pixel_pitch_m };
    let camera = Camera::new(lens, &grid, to_world, autofocus_distance_m)?.with_cells(sensor.cells);
    Ok(if sensor.shutter.scans() { camera.scanning() } else { camera })
}

/// The camera of a capture in its place, focused on what autofocus finds: `closest` is asked for it then only.
pub fn place_camera(capture: &Capture, closest: impl Fn(&Ray) -> Option<Hit>) -> Result<Camera> {
    place_camera_at(capture, capture.camera_to_world, closest)
}

/// The camera of a capture at another pose, focused in the same way.
pub(super) fn place_camera_at(
    capture: &Capture,
    to_world: DAffine3,
    closest: impl Fn(&Ray) -> Option<Hit>,
) -> Result<Camera> {
    let place = |lens: &_, distance| {
        let camera = camera_of(lens, &capture.sensor, to_world, distance);
        camera.map_err(|invalid| capture.source.error(invalid.within("lens")))
    };
    let covered = |camera: Camera| match camera.check_coverage() {
        Ok(()) => Ok(camera),
        Err(invalid) => Err(capture.source.error(invalid.within("lens"))),
    };
    let Focus::Autofocus { pixel } = capture.lens.focus else {
        return place(&capture.lens, f64::NAN).and_then(covered);
    };
    // Focusing moves the sensor and with it the direction of the chief ray; a few rounds settle it.
    let mut lens = capture.lens.clone();
    let mut distance = f64::INFINITY;
    for _ in 0..4 {
        lens.focus = if distance.is_finite() { Focus::Distance(distance) } else { Focus::Infinity };
        let hit = place(&lens, distance)?.chief_ray(pixel.into()).and_then(|ray| closest(&ray));
        distance = hit.map_or(f64::INFINITY, |hit| f64::from(hit.t));
        if distance <= lens.focal_length_m {
            break;
        }
    }
    place(&capture.lens, distance).and_then(covered)
}

/// The camera of a capture that is not rendered: its scene is built only where autofocus has to look at it.
pub fn standalone_camera(capture: &Capture) -> Result<Camera> {
    let built = OnceCell::new();
    let build = || scene::build(capture.scene.clone(), &importance(&responses(capture)));
    place_camera(capture, |ray| built.get_or_init(build).closest(ray))
}

/// The camera of a capture that is not rendered, as it takes the capture's first picture.
pub fn standalone_recording_camera(capture: &Capture) -> Result<Camera> {
    let camera = standalone_camera(capture)?;
    Ok(match &capture.recording {
        Some(recording) => camera.recording(recording.clone()),
        None => camera,
    })
}
