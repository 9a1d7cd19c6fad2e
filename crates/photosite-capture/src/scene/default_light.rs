//! The light of a scene file that is given in place of a capture and has no lights of its own: a clear day, and a
//! ground that catches the shadow.
//!
//! The sun stands 40° high and 50° to the left of the camera, as seen from the subject: light from the side and the
//! front, which shows the shape of things. The sky, by Hosek and Wilkie, lights what the sun does not reach, and the
//! ground under the subject reflects as much as the sky takes it to: 0.3, a neutral grey. All is absolute: some 100 000
//! lux fall on the ground. Automatic exposure aims at a mean of 0.2 there, as cameras do, since the highlight of a
//! polished thing would leave all else dark. Where the file has cameras, the left is that of the first; where a capture
//! places another, the sun stays, so that images of many sides are those of one day.

use glam::DVec3;
use serde_json::json;

use super::super::camera::framing::TOWARDS_CAMERA;
use super::super::tree::source::CaptureSource;
use photosite_transport::scene::description::SceneDescription;

const SUN_ELEVATION_DEG: f64 = 40.0;
/// Azimuth of the sun from the camera, seen from above, clockwise.
const SUN_LEFT_OF_CAMERA_DEG: f64 = 50.0;
/// Reflectance of the ground, which the sky sees.
const GROUND_REFLECTANCE: f64 = 0.3;
const TURBIDITY: f64 = 3.0;
/// Mean that automatic exposure aims at, a part of saturation.
const MEAN: f64 = 0.2;

/// Gives a capture this light, unless it has an environment; the ground comes with the sky. Where an override changes
/// keys of the sky without a place for the sun, the others are those of this light.
pub(crate) fn set(source: &mut CaptureSource, scene: &SceneDescription) {
    const SKY: &str = "scene.environment.sky";
    let places_sun = ["sun_elevation_deg", "date_time"].iter().any(|key| source.has(&format!("{SKY}.{key}")));
    if source.has("scene.environment") && (places_sun || !source.has(SKY)) {
        return;
    }
    let sky = json!({
        "sun_elevation_deg": SUN_ELEVATION_DEG,
        "sun_azimuth_deg": sun_azimuth_deg(scene),
        "turbidity": TURBIDITY,
        "ground_albedo": GROUND_REFLECTANCE,
    });
    if source.has(SKY) {
        source.complete(&["scene", "environment", "sky"], &sky);
    } else {
        source.set_default("scene", "environment", &json!({ "sky": sky }));
    }
    if !source.has("scene.backdrop") {
        source.set_default("scene", "ground", &json!({ "reflectance": GROUND_REFLECTANCE }));
    }
    set_metering(source);
}

/// Meters the image as a whole, unless a time or another metering is stated.
fn set_metering(source: &mut CaptureSource) {
    let keys = ["time_s", "bracket_times_s", "auto_target", "auto_brighter_part", "auto_mean", "gain_control"];
    let is_stated = keys.iter().any(|key| source.has(&format!("exposure.{key}")));
    let is_off = source.has("exposure.auto") && !matches!(source.read("exposure.auto"), Ok(Some(true)));
    if !(is_stated || is_off) {
        source.set_default("exposure", "auto_mean", &MEAN.into());
    }
}

/// Azimuth of the sun, degrees from north (−Z) over east (+X): integers, 0 to 359.
fn sun_azimuth_deg(scene: &SceneDescription) -> f64 {
    let towards_camera = scene.cameras.first().map_or(TOWARDS_CAMERA, |camera| camera.to_world.matrix3.z_axis);
    // Of a camera that looks straight down, the lower edge of the image is where its viewer stands.
    let level = DVec3 { y: 0.0, ..towards_camera };
    let up = scene.cameras.first().map_or(DVec3::Y, |camera| camera.to_world.matrix3.y_axis);
    let level = if level.length() > 1e-3 * towards_camera.length() { level } else { -up };
    let camera_deg = level.x.atan2(-level.z).to_degrees();
    (camera_deg + SUN_LEFT_OF_CAMERA_DEG).round().rem_euclid(360.0)
}
