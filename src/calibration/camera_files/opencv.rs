//! OpenCV's FileStorage as YAML, with the keys that its calibration samples write.

use super::CalibratedCamera;
use super::yaml::{list, number, quoted};
use crate::Invalid;
use crate::optics::Projection;

/// Matrix, coefficients and pose (x_camera = R·x_world + t). `distortion_model` names the functions that take the
/// coefficients: `calib3d`, `fisheye` or `omnidir`, the last with `xi`.
pub fn opencv(camera: &CalibratedCamera) -> Result<String, Invalid> {
    let (model, xi) = match camera.projection {
        Projection::Perspective | Projection::BrownConrady(_) => ("calib3d", None),
        Projection::KannalaBrandt { .. } => ("fisheye", None),
        Projection::Omnidirectional { xi, .. } => ("omnidir", Some(xi)),
        Projection::Polynomial { .. } | Projection::Division { .. } | Projection::Equirectangular => {
            return Err(camera.no_model("OpenCV", "take brown-conrady, kannala-brandt or an omnidirectional lens"));
        }
    };
    if xi.is_none() {
        camera.without_skew("OpenCV")?;
    }
    let [width, height] = camera.resolution;
    let pose = camera.from_world();
    let rotation = pose.matrix3.transpose().to_cols_array().map(|x| x + 0.0);
    let coefficients = camera.projection.coefficients();
    let xi = xi.map_or(String::new(), |xi| format!("xi: {}\n", number(xi)));
    Ok(format!(
        "%YAML:1.0\n---\ncamera_name: {}\nimage_width: {width}\nimage_height: {height}\n{}distortion_model: {model}\n{xi}{}{}{}",
        quoted(&camera.name),
        matrix("camera_matrix", 3, &camera.matrix()),
        matrix("distortion_coefficients", 1, &coefficients),
        matrix("rotation", 3, &rotation),
        matrix("translation_m", 3, &pose.translation.to_array()),
    ))
}

fn matrix(key: &str, rows: usize, values: &[f64]) -> String {
    let columns = values.len() / rows;
    format!("{key}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: {}\n", list(values))
}
