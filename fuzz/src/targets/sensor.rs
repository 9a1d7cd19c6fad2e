//! Sensor files.

use photosite::Sandbox;
use photosite::capture::read_sensor_file;
use crate::written;

pub(crate) fn target(data: &[u8]) {
    let _ = read_sensor_file(&written("sensor.toml", data), &Sandbox::default());
}
