//! OpenCV's FileStorage as YAML, with the keys that its calibration samples write.

use super::yaml::{list, number, quoted};
use super::{CalibratedCamera, StereoPair, by_rows};
use photosite_core::Invalid;
use photosite_core::projection::CalibrationModel;

/// Text of a camera: matrix, coefficients and pose (x_camera = R·x_world + t). `distortion_model` names the functions
/// that take the coefficients: `calib3d`, `fisheye` or `omnidir`, the last with `xi`.
pub fn opencv(camera: &CalibratedCamera) -> Result<String, Invalid> {
    let (model, xi) = match camera.projection.calibration_model() {
        Some(CalibrationModel::Pinhole | CalibrationModel::BrownConrady(_)) => ("calib3d", None),
        Some(CalibrationModel::KannalaBrandt { .. }) => ("fisheye", None),
        Some(CalibrationModel::Omnidirectional { xi, .. }) => ("omnidir", Some(xi)),
        None => {
            return Err(camera.no_model("OpenCV", "take brown-conrady, kannala-brandt or an omnidirectional lens"));
        }
    };
    if xi.is_none() {
        camera.without_skew("OpenCV")?;
    }
    let [width, height] = camera.resolution;
    let pose = camera.from_world();
    let rotation = by_rows(&pose.matrix3);
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

/// Text of a stereo pair as `stereoCalibrate` and `stereoRectify` give it, under the names of OpenCV's sample: matrices
/// and coefficients of both cameras (M1, D1, M2, D2), R and T from the first to the second, E and F, R1, R2, P1, P2 and
/// Q. `distortion_model` is that of both. Added are the epipoles e1 and e2 and the homographies H1 and H2 of
/// rectification ([`StereoPair::epipoles`], [`StereoPair::homographies`]); F, e1, e2, H1 and H2 are those of pixels
/// without distortion, cv2.undistortPoints(…, P = M). F is what its definition gives; stereoCalibrate divides it by its
/// last element.
pub fn opencv_pair(pair: &StereoPair<'_>) -> Result<String, Invalid> {
    let [first, second] = pair.cameras;
    let model = |camera: &CalibratedCamera| match camera.projection.calibration_model() {
        Some(CalibrationModel::Pinhole | CalibrationModel::BrownConrady(_)) => Ok("calib3d"),
        Some(CalibrationModel::KannalaBrandt { .. }) => Ok("fisheye"),
        Some(CalibrationModel::Omnidirectional { .. }) | None => {
            Err(camera.no_model("OpenCV's stereo", "take brown-conrady or kannala-brandt"))
        }
    };
    let models = [model(first)?, model(second)?];
    if models[0] != models[1] || first.resolution != second.resolution {
        let message = format!(
            "OpenCV's stereo files need two cameras of one kind and size, but {} and {} differ",
            first.name, second.name
        );
        return Err(Invalid::new("cameras", message).help("give both the same projection and resolution_px"));
    }
    pair.cameras.iter().try_for_each(|camera| camera.without_skew("OpenCV"))?;
    let [width, height] = first.resolution;
    let [p1, p2] = pair.projections();
    let [e1, e2] = pair.epipoles();
    let [h1, h2] = pair.homographies();
    let matrices: String = [
        ("M1", 3, first.matrix().to_vec()),
        ("D1", 1, first.projection.coefficients()),
        ("M2", 3, second.matrix().to_vec()),
        ("D2", 1, second.projection.coefficients()),
        ("R", 3, by_rows(&pair.from_first.matrix3).to_vec()),
        ("T", 3, pair.from_first.translation.to_array().to_vec()),
        ("E", 3, by_rows(&pair.essential()).to_vec()),
        ("F", 3, by_rows(&pair.fundamental()).to_vec()),
        ("e1", 3, e1.to_array().to_vec()),
        ("e2", 3, e2.to_array().to_vec()),
        ("R1", 3, by_rows(&pair.rotations[0]).to_vec()),
        ("R2", 3, by_rows(&pair.rotations[1]).to_vec()),
        ("P1", 3, p1.to_vec()),
        ("P2", 3, p2.to_vec()),
        ("H1", 3, by_rows(&h1).to_vec()),
        ("H2", 3, by_rows(&h2).to_vec()),
        ("Q", 4, pair.disparity_to_depth().to_vec()),
    ]
    .into_iter()
    .map(|(key, rows, values)| matrix(key, rows, &values.iter().map(|x| x + 0.0).collect::<Vec<_>>()))
    .collect();
    Ok(format!(
        "%YAML:1.0\n---\ncamera_names: [ {}, {} ]\nimage_width: {width}\nimage_height: {height}\ndistortion_model: {}\n{matrices}",
        quoted(&first.name),
        quoted(&second.name),
        models[0],
    ))
}

fn matrix(key: &str, rows: usize, values: &[f64]) -> String {
    let columns = values.len() / rows;
    format!("{key}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: {}\n", list(values))
}
