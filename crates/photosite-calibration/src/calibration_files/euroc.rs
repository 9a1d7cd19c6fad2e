//! `sensor.yaml` of a camera in the layout of the EuRoC data sets.

use super::calibration::{Calibration, StatedPose, to_frame, unused};
use super::models::{at_centres, brown_conrady, kannala_brandt};
use super::tree::{Fault, Table, unknown};

const WITHOUT_MEANING: [&str; 3] = ["sensor_type", "comment", "rate_hz"];

pub(super) fn camera(file: &Table<'_>) -> Result<Calibration, Fault> {
    let model = file.require("camera_model", "camera_model: pinhole")?;
    match model.text()? {
        "pinhole" => {}
        other => return Err(unknown(&model, "camera model", other, ["pinhole"].into_iter())),
    }
    let intrinsics = file.require("intrinsics", "intrinsics: [458.654, 457.296, 367.215, 248.375]")?;
    let coefficients =
        file.require("distortion_coefficients", "distortion_coefficients: [-0.28, 0.07, 0.0002, 0.00002]")?;
    let model = file.require("distortion_model", "distortion_model: radial-tangential")?;
    let projection = match model.text()? {
        "radial-tangential" => brown_conrady(&coefficients, &coefficients.array::<4>("k1, k2, p1, p2")?)?,
        "equidistant" => kannala_brandt(&coefficients)?,
        other => {
            return Err(unknown(&model, "distortion model", other, ["radial-tangential", "equidistant"].into_iter()));
        }
    };
    let resolution = file.require("resolution", "resolution: [752, 480]")?.resolution()?;
    // T_BS takes the sensor's coordinates to the body's.
    let body = file.get("T_BS").map(|pose| pose.pose()).transpose()?;
    let pose = |to_body: glam::DAffine3| StatedPose { name: "body".to_owned(), to_frame: to_frame(&to_body.inverse()) };
    Ok(Calibration {
        name: "camera".to_owned(),
        intrinsics: at_centres(&intrinsics, intrinsics.array("fu, fv, cu, cv")?, 0.0)?,
        projection,
        resolution: Some(resolution),
        poses: body.map(pose).into_iter().collect(),
        warnings: unused(&file.unread(&WITHOUT_MEANING)).into_iter().collect(),
    })
}
