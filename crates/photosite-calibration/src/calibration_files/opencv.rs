//! OpenCV's calibrations: what `cv::FileStorage` writes as YAML, XML or JSON, and lists of scripts. Keys are those of
//! photosite, of OpenCV's samples and of its tutorials.

use super::calibration::{Calibration, StatedPose, to_frame, unused};
use super::models::{brown_conrady, kannala_brandt, of_matrix, omnidirectional, resolution, without_skew};
use super::tree::{Fault, Item, Table, Value, unknown};
use crate::camera_files::half_turn;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Names of a camera matrix.
pub(super) const MATRICES: [&str; 7] =
    ["camera_matrix", "Camera_Matrix", "cameraMatrix", "CameraMatrix", "camera_Matrix", "K", "mtx"];
/// Names of the coefficients.
const COEFFICIENTS: [&str; 9] = [
    "distortion_coefficients",
    "Distortion_Coefficients",
    "distortionCoefficients",
    "distCoeffs",
    "dist_coeffs",
    "dist_coeff",
    "dist_coefs",
    "dist",
    "D",
];
/// Names of columns and rows.
const SIZE: [&[&str]; 2] = [
    &["image_width", "image_Width", "imageWidth", "width"],
    &["image_height", "image_Height", "imageHeight", "height"],
];
/// Keys of how the calibration was made, and of what follows from others.
const WITHOUT_MEANING: [&str; 26] = [
    "calibration_time",
    "camera_names",
    "camera_model",
    "avg_reprojection_error",
    "per_view_reprojection_errors",
    "rms",
    "rms_error",
    "reprojection_error",
    "nframes",
    "nr_of_frames",
    "board_width",
    "board_height",
    "square_size",
    "marker_size",
    "aspectRatio",
    "fix_aspect_ratio",
    "flags",
    "grid_points",
    "image_points",
    "e1",
    "e2",
    "E",
    "F",
    "H1",
    "H2",
    "Q",
];

/// Models of OpenCV's three modules.
#[derive(Clone, Copy, PartialEq)]
enum Module {
    Calib3d,
    Fisheye,
    Omnidir,
}

pub(super) fn cameras(file: &Table<'_>) -> Result<Vec<Calibration>, Fault> {
    if file.has_any(&["M1"]) {
        return pair(file);
    }
    let matrix = file.get_any(&MATRICES).ok_or_else(|| file.missing(MATRICES[0], "camera_matrix"))?;
    let (module, assumption) = module(file)?;
    let name = file.get("camera_name").map(|name| name.text()).transpose()?.unwrap_or("camera");
    let mut camera = camera(file, name, matrix, file.get_any(&COEFFICIENTS), module)?;
    camera.warnings.extend(assumption.filter(|_| ambiguous(file)));
    camera.poses.extend(pose(file, "world", ["rotation", "rotation_matrix"], ["translation_m", "translation"])?);
    match file.get("extrinsic_parameters").map(|rows| views(&rows)) {
        Some(Ok(views)) => camera.poses.extend(views),
        Some(Err(warning)) => camera.warnings.push(warning),
        None => {}
    }
    camera.warnings.extend(unused(&file.unread(&WITHOUT_MEANING)));
    Ok(vec![camera])
}

/// Both cameras of a stereo calibration.
fn pair(file: &Table<'_>) -> Result<Vec<Calibration>, Fault> {
    let names = match file.get("camera_names") {
        Some(names) => pair_names(&names),
        None => ["1", "2"].map(str::to_owned),
    };
    let (module, assumption) = module(file)?;
    let from_first = pose(file, &names[0], ["R", "R"], ["T", "T"])?;
    let mut cameras = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let [m, d] = [["M1", "D1"], ["M2", "D2"]][i];
        let matrix = file.require(m, &format!("{m}, a camera matrix"))?;
        let mut camera = camera(file, name, matrix, file.get(d), module)?;
        camera.warnings.extend(assumption.clone().filter(|_| ambiguous(file)));
        // Of the first camera: it stands upright, and looks along −z.
        camera.poses.extend(from_first.clone().map(|second| {
            let to_frame = if i == 0 { DAffine3::IDENTITY } else { half_turn() * second.to_frame };
            StatedPose { to_frame, ..second }
        }));
        cameras.push(camera);
    }
    let rest = file.unread(&WITHOUT_MEANING);
    // Rectification follows from the others.
    let rest: Vec<String> = rest.into_iter().filter(|key| !["R1", "R2", "P1", "P2"].contains(&key.as_str())).collect();
    cameras.iter_mut().for_each(|camera| camera.warnings.extend(unused(&rest)));
    Ok(cameras)
}

fn pair_names(names: &Item<'_>) -> [String; 2] {
    let of = |i: usize| match &names.node.value {
        Value::List(nodes) => match nodes.get(i).map(|node| &node.value) {
            Some(Value::Scalar(name)) => Some(name.clone()),
            Some(Value::List(_) | Value::Table(_)) | None => None,
        },
        Value::Scalar(_) | Value::Table(_) => None,
    };
    [0, 1].map(|i| of(i).unwrap_or_else(|| (i + 1).to_string()))
}

/// Module that the file names; else calib3d, and a warning that this is assumed.
fn module(file: &Table<'_>) -> Result<(Module, Option<String>), Fault> {
    let is_fisheye = file.get("fisheye_model").map(|flag| flag.text().map(|flag| !["0", "false"].contains(&flag)));
    if let Some(is_fisheye) = is_fisheye {
        return is_fisheye.map(|is_fisheye| (if is_fisheye { Module::Fisheye } else { Module::Calib3d }, None));
    }
    if let Some(model) = file.get("distortion_model") {
        return match model.text()? {
            "calib3d" => Ok((Module::Calib3d, None)),
            "fisheye" => Ok((Module::Fisheye, None)),
            "omnidir" => Ok((Module::Omnidir, None)),
            other => Err(unknown(&model, "model of OpenCV", other, ["calib3d", "fisheye", "omnidir"].into_iter())),
        };
    }
    if file.has_any(&["xi"]) {
        return Ok((Module::Omnidir, None));
    }
    let words = "the file does not name its model, taken for that of cv2.projectPoints; a file of cv2.fisheye needs \
                 distortion_model: fisheye";
    Ok((Module::Calib3d, Some(words.to_owned())))
}

/// Whether the number of coefficients is that of a fisheye, too.
fn ambiguous(file: &Table<'_>) -> bool {
    let coefficients = file.get_any(&COEFFICIENTS).or_else(|| file.get("D1"));
    coefficients.is_some_and(|item| item.numbers().is_ok_and(|c| c.len() == 4))
}

fn camera(
    file: &Table<'_>,
    name: &str,
    matrix: Item<'_>,
    coefficients: Option<Item<'_>>,
    module: Module,
) -> Result<Calibration, Fault> {
    let intrinsics = of_matrix(&matrix)?;
    let coefficients = coefficients
        .ok_or_else(|| file.missing(COEFFICIENTS[0], "distortion_coefficients, zeros where there is none"))?;
    let projection = match module {
        Module::Calib3d => {
            without_skew(&matrix, &intrinsics, "cv2.projectPoints")?;
            brown_conrady(&coefficients, &coefficients.numbers()?)?
        }
        Module::Fisheye => kannala_brandt(&coefficients)?,
        Module::Omnidir => {
            let xi = file.require("xi", "xi: 1.1")?;
            let [value] = xi.array::<1>("ξ")?;
            omnidirectional(&xi, value, coefficients.array("k1, k2, p1, p2")?)?
        }
    };
    let resolution = match file.get("image_size") {
        Some(size) => Some(size.resolution()?),
        None => resolution(file, SIZE)?,
    };
    Ok(Calibration {
        name: name.to_owned(),
        intrinsics,
        projection,
        resolution,
        poses: Vec::new(),
        warnings: Vec::new(),
    })
}

/// Poses of the views of a calibration, from the target of each: a row of rotation vector and translation, as OpenCV's
/// samples write them. `Err` says that they are of another form; the camera can do without.
fn views(rows: &Item<'_>) -> Result<Vec<StatedPose>, String> {
    let of_row = |(number, row): (usize, Vec<f64>)| {
        let [x, y, z, shift @ ..] = <[f64; 6]>::try_from(row).ok().filter(|row| row.iter().all(|x| x.is_finite()))?;
        let turn = DQuat::from_scaled_axis(DVec3::new(x, y, z));
        let from_target = DAffine3::from_rotation_translation(turn, DVec3::from_array(shift));
        Some(StatedPose { name: format!("view {number}"), to_frame: to_frame(&from_target) })
    };
    let poses = rows.rows().ok().and_then(|rows| rows.into_iter().enumerate().map(of_row).collect());
    poses.ok_or_else(|| {
        "extrinsic_parameters are not used: expected rows of six numbers, rotation vector and translation of a view"
            .to_owned()
    })
}

/// Pose of a rotation, a matrix or a vector, and a translation: x_camera = R·x + t.
fn pose(file: &Table<'_>, name: &str, turn: [&str; 2], shift: [&str; 2]) -> Result<Option<StatedPose>, Fault> {
    let (Some(rotation), Some(translation)) = (file.get_any(&turn), file.get_any(&shift)) else { return Ok(None) };
    let matrix = match rotation.numbers()?.as_slice() {
        [x, y, z] => DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(*x, *y, *z))),
        _ => rotation.rotation()?,
    };
    let translation = DVec3::from_array(translation.array("x, y, z")?);
    let from_frame = DAffine3::from_mat3_translation(matrix, translation);
    Ok(Some(StatedPose { name: name.to_owned(), to_frame: to_frame(&from_frame) }))
}
