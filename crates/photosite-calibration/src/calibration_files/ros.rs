//! ROS' `camera_info`: the YAML of `camera_calibration_parsers`, and a message as text.

use super::calibration::{Calibration, unused};
use super::models::{brown_conrady, kannala_brandt, of_matrix, resolution, without_skew};
use super::tree::{Fault, Table, unknown};

/// Keys that files of OpenCV do not have.
pub(super) const OWN_KEYS: [&str; 3] = ["rectification_matrix", "projection_matrix", "binning_x"];
/// Names of models, and of those that the image pipeline takes for the same.
const MODELS: [&str; 4] = ["plumb_bob", "rational_polynomial", "equidistant", "fisheye"];
/// Keys of the rectified image and of the message around it. Photosite's raw image is not rectified.
const WITHOUT_MEANING: [&str; 10] = [
    "header",
    "rectification_matrix",
    "R",
    "r",
    "projection_matrix",
    "P",
    "p",
    "camera_name",
    "roi",
    "camera_info_url",
];

/// Whether a distortion model is stated that is ROS'.
pub(super) fn has_model(file: &Table<'_>) -> bool {
    let model = file.items().find(|(key, _)| *key == "distortion_model");
    // OpenCV's own name `fisheye` is ROS', too, only beside what only ROS has.
    model.is_some_and(|(_, item)| item.text().is_ok_and(|name| MODELS[..3].contains(&name)))
}

pub(super) fn camera(file: &Table<'_>) -> Result<Calibration, Fault> {
    const MATRIX: &str = "camera_matrix with rows, cols and data";
    const COEFFICIENTS: [&str; 3] = ["distortion_coefficients", "D", "d"];
    let matrix = file.get_any(&["camera_matrix", "K", "k"]).ok_or_else(|| file.missing("camera_matrix", MATRIX))?;
    let intrinsics = of_matrix(&matrix)?;
    without_skew(&matrix, &intrinsics, "the image pipeline of ROS")?;
    let coefficients = file
        .get_any(&COEFFICIENTS)
        .ok_or_else(|| file.missing(COEFFICIENTS[0], "distortion_coefficients with rows, cols and data"))?;
    let model = file.require("distortion_model", "distortion_model: plumb_bob")?;
    let projection = match model.text()? {
        "plumb_bob" | "rational_polynomial" | "" => brown_conrady(&coefficients, &coefficients.numbers()?)?,
        "equidistant" | "fisheye" => kannala_brandt(&coefficients)?,
        other => return Err(unknown(&model, "distortion model of ROS", other, MODELS.into_iter())),
    };
    for key in ["binning_x", "binning_y"] {
        if let Some(binning) = file.get(key)
            && binning.number()? > 1.0
        {
            let message = "the matrix is that of the image before binning";
            return Err(binning.fault(message).help("write 0 there, and binning of the capture's exposure"));
        }
    }
    let size = resolution(file, [&["image_width", "width"], &["image_height", "height"]])?;
    Ok(Calibration {
        name: file.get("camera_name").map_or(Ok("camera"), |name| name.text())?.to_owned(),
        intrinsics,
        projection,
        resolution: Some(size.ok_or_else(|| file.missing("image_width", "image_width: 640"))?),
        poses: Vec::new(),
        warnings: unused(&file.unread(&WITHOUT_MEANING)).into_iter().collect(),
    })
}
