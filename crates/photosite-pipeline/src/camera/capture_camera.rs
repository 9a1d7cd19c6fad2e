//! The camera that lens, sensor and pose of a capture make.

use glam::DAffine3;

use photosite_capture::Capture;
use photosite_core::Invalid;
use photosite_sensor::SensorModel;
use photosite_transport::optics::{Camera, LensDescription, PixelGrid};

/// Columns and rows of the image.
pub fn pixels(capture: &Capture) -> [u32; 2] {
    in_u32(capture.sensor().resolution)
}

pub(crate) fn in_u32(resolution: [usize; 2]) -> [u32; 2] {
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
