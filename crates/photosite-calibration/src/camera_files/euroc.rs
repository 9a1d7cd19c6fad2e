//! `sensor.yaml` of a camera in the layout of the EuRoC data sets.

use glam::DAffine3;

use super::yaml::{list, number, quoted};
use super::{CalibratedCamera, four, opencv_pose, rows};
use photosite_core::Invalid;
use photosite_core::projection::CalibrationModel;

/// Text of `sensor.yaml`. `body` takes the body's coordinates to those of the world; `T_BS` takes those of the sensor
/// (x right, y down, z forward) to the body's.
pub fn euroc(camera: &CalibratedCamera, body: &DAffine3, rate_hz: f64) -> Result<String, Invalid> {
    let no_model = || camera.no_model("EuRoC", "take k1, k2, p1 and p2 of brown-conrady, or kannala-brandt");
    let (model, coefficients) = match camera.projection.calibration_model() {
        Some(CalibrationModel::Pinhole) => ("radial-tangential", [0.0; 4]),
        Some(CalibrationModel::BrownConrady(distortion)) => {
            ("radial-tangential", four(&distortion).ok_or_else(no_model)?)
        }
        Some(CalibrationModel::KannalaBrandt { k }) => ("equidistant", k),
        Some(CalibrationModel::Omnidirectional { .. }) | None => return Err(no_model()),
    };
    camera.without_skew("EuRoC")?;
    let [width, height] = camera.resolution;
    let to_body = body.inverse() * opencv_pose(&camera.to_world);
    Ok(format!(
        "sensor_type: camera\ncomment: {}\nT_BS:\n  cols: 4\n  rows: 4\n  data: {}\nrate_hz: {}\nresolution: [{width}, {height}]\n\
         camera_model: pinhole\nintrinsics: {}\ndistortion_model: {model}\ndistortion_coefficients: {}\n",
        quoted(&camera.name),
        list(rows(&to_body).as_flattened()),
        number(rate_hz),
        list(&camera.at_centres()),
        list(&coefficients),
    ))
}
