//! Sensor files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::Sandbox;
use photosite::capture::read_sensor_file;
use photosite_fuzz::written;

fuzz_target!(|data: &[u8]| {
    let _ = read_sensor_file(&written("sensor.toml", data), &Sandbox::default());
});
