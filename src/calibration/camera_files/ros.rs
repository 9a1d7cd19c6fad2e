//! `camera_info` of ROS as `camera_calibration_parsers` reads it from YAML.

use super::CalibratedCamera;
use super::yaml::list;
use crate::Invalid;
use crate::optics::{BrownConrady, Projection};

/// The camera on its own: rectification is the identity, and the projection matrix is the camera's.
pub fn ros(camera: &CalibratedCamera) -> Result<String, Invalid> {
    let model = match camera.projection {
        Projection::Perspective => "plumb_bob",
        Projection::BrownConrady(BrownConrady { k: [.., 0.0, 0.0, 0.0], s: [0.0, 0.0, 0.0, 0.0], .. }) => "plumb_bob",
        Projection::BrownConrady(BrownConrady { s: [0.0, 0.0, 0.0, 0.0], .. }) => "rational_polynomial",
        Projection::KannalaBrandt { .. } => "equidistant",
        Projection::BrownConrady(_)
        | Projection::Polynomial { .. }
        | Projection::Division { .. }
        | Projection::Equirectangular
        | Projection::Omnidirectional { .. } => {
            return Err(camera.no_model("ROS", "take brown-conrady without s, or kannala-brandt"));
        }
    };
    camera.without_skew("ROS")?;
    let [width, height] = camera.resolution;
    let [fx, fy, cx, cy] = camera.at_centres();
    // Names of ROS have letters, digits and underscores only.
    let name: String = camera.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let projection = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    Ok(format!(
        "image_width: {width}\nimage_height: {height}\ncamera_name: \"{name}\"\n{}distortion_model: {model}\n{}{}{}",
        matrix("camera_matrix", 3, &camera.matrix()),
        matrix("distortion_coefficients", 1, &camera.projection.coefficients()),
        matrix("rectification_matrix", 3, &identity),
        matrix("projection_matrix", 3, &projection),
    ))
}

fn matrix(key: &str, rows: usize, values: &[f64]) -> String {
    format!("{key}:\n  rows: {rows}\n  cols: {}\n  data: {}\n", values.len() / rows, list(values))
}
