//! Kalibr's `camchain.yaml`.

use super::yaml::{list, quoted};
use super::{CalibratedCamera, four, opencv_pose, rows};
use photosite_core::Invalid;
use photosite_core::projection::CalibrationModel;

/// Text of `camchain.yaml`: the cameras of a rig, in order. Each but the first has the pose from the one before it,
/// `T_cn_cnm1`, which takes points from that camera's coordinates to its own.
pub fn kalibr(cameras: &[CalibratedCamera]) -> Result<String, Invalid> {
    let mut text = String::new();
    for (i, camera) in cameras.iter().enumerate() {
        camera.without_skew("Kalibr")?;
        let intrinsics = camera.at_centres();
        let no_model = || camera.no_model("Kalibr", "take k1, k2, p1 and p2 of brown-conrady, or kannala-brandt");
        let (model, intrinsics, distortion, coefficients) =
            match camera.projection.calibration_model().ok_or_else(no_model)? {
                CalibrationModel::Pinhole => ("pinhole", intrinsics.to_vec(), "none", Vec::new()),
                CalibrationModel::KannalaBrandt { k } => ("pinhole", intrinsics.to_vec(), "equidistant", k.to_vec()),
                CalibrationModel::Omnidirectional { xi, distortion } => {
                    let coefficients = four(&distortion).ok_or_else(no_model)?;
                    ("omni", [&[xi], intrinsics.as_slice()].concat(), "radtan", coefficients.to_vec())
                }
                CalibrationModel::BrownConrady(distortion) => {
                    let coefficients = four(&distortion).ok_or_else(no_model)?;
                    ("pinhole", intrinsics.to_vec(), "radtan", coefficients.to_vec())
                }
            };
        let [width, height] = camera.resolution;
        text += &format!("cam{i}:\n");
        if let Some(before) = i.checked_sub(1).map(|i| &cameras[i]) {
            text += "  T_cn_cnm1:\n";
            for row in rows(&(camera.from_world() * opencv_pose(&before.to_world))) {
                text += &format!("  - {}\n", list(&row));
            }
        }
        text += &format!(
            "  camera_model: {model}\n  intrinsics: {}\n  distortion_model: {distortion}\n  distortion_coeffs: {}\n  \
             resolution: [{width}, {height}]\n  rostopic: {}\n",
            list(&intrinsics),
            list(&coefficients),
            quoted(&format!("/cam{i}/image_raw")),
        );
    }
    Ok(text)
}
