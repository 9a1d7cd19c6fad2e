//! `camera_info` of ROS as `camera_calibration_parsers` reads it from YAML.

use glam::DMat3;

use super::yaml::list;
use super::{CalibratedCamera, StereoPair, by_rows};
use photosite_core::Invalid;
use photosite_core::projection::{BrownConrady, CalibrationModel};

/// File of a single camera: rectification is the identity, and the projection matrix is the camera's.
pub fn ros(camera: &CalibratedCamera) -> Result<String, Invalid> {
    let [fx, fy, cx, cy] = camera.at_centres();
    let projection = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    camera_info(camera, &DMat3::IDENTITY, &projection)
}

/// Files of both cameras of a pair: the rectification rotation and the projection matrix of each, of which the second
/// has Tx = −fx'·b (or Ty for cameras one above the other) in its last column.
pub fn ros_pair(pair: &StereoPair<'_>) -> Result<[String; 2], Invalid> {
    let [first, second] = pair.projections();
    let info = |i: usize, projection| camera_info(pair.cameras[i], &pair.rotations[i], projection);
    Ok([info(0, &first)?, info(1, &second)?])
}

/// ROS name of a lens model, and its coefficients: 5 of `plumb_bob`, 8 of `rational_polynomial`, 4 of `equidistant`.
pub fn ros_distortion(camera: &CalibratedCamera) -> Result<(&'static str, Vec<f64>), Invalid> {
    let model = match camera.projection.calibration_model() {
        Some(CalibrationModel::Pinhole) => "plumb_bob",
        Some(CalibrationModel::BrownConrady(BrownConrady {
            k: [.., 0.0, 0.0, 0.0], s: [0.0, 0.0, 0.0, 0.0], ..
        })) => "plumb_bob",
        Some(CalibrationModel::BrownConrady(BrownConrady { s: [0.0, 0.0, 0.0, 0.0], .. })) => "rational_polynomial",
        Some(CalibrationModel::KannalaBrandt { .. }) => "equidistant",
        Some(CalibrationModel::BrownConrady(_) | CalibrationModel::Omnidirectional { .. }) | None => {
            return Err(camera.no_model("ROS", "take brown-conrady without s, or kannala-brandt"));
        }
    };
    camera.without_skew("ROS")?;
    Ok((model, camera.projection.coefficients()))
}

/// Name as topics and files of ROS have it: letters, digits and underscores only.
pub fn ros_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

fn camera_info(camera: &CalibratedCamera, rectification: &DMat3, projection: &[f64; 12]) -> Result<String, Invalid> {
    let (model, coefficients) = ros_distortion(camera)?;
    let [width, height] = camera.resolution;
    let name = ros_name(&camera.name);
    Ok(format!(
        "image_width: {width}\nimage_height: {height}\ncamera_name: \"{name}\"\n{}distortion_model: {model}\n{}{}{}",
        matrix("camera_matrix", 3, &camera.matrix()),
        matrix("distortion_coefficients", 1, &coefficients),
        matrix("rectification_matrix", 3, &by_rows(rectification)),
        matrix("projection_matrix", 3, projection),
    ))
}

fn matrix(key: &str, rows: usize, values: &[f64]) -> String {
    format!("{key}:\n  rows: {rows}\n  cols: {}\n  data: {}\n", values.len() / rows, list(values))
}
