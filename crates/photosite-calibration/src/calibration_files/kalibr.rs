//! Kalibr's `camchain.yaml` and `camchain-imucam.yaml`.

use glam::DAffine3;

use super::calibration::{Calibration, StatedPose, to_frame, unused};
use super::models::{at_centres, brown_conrady, kannala_brandt, omnidirectional};
use super::tree::{Fault, Item, Table, Value, unknown};
use crate::camera_files::half_turn;
use photosite_core::projection::Projection;

/// Keys that say nothing of what the camera sees.
const WITHOUT_MEANING: [&str; 3] = ["rostopic", "cam_overlaps", "timeshift_cam_imu"];

/// Whether a key at the top is a camera's.
pub(super) fn is_camera(name: &str, item: &Item<'_>) -> bool {
    let has_model = |entries: &[(String, _)]| entries.iter().any(|(key, _)| key == "camera_model");
    name.starts_with("cam") && matches!(&item.node.value, Value::Table(entries) if has_model(entries))
}

/// Camera, and how it stands to the one before and to the IMU.
struct Link {
    camera: Calibration,
    from_previous: Option<DAffine3>,
    from_imu: Option<DAffine3>,
}

pub(super) fn cameras(file: &Table<'_>) -> Result<Vec<Calibration>, Fault> {
    let mut chain = Vec::new();
    for (name, item) in file.items().filter(|(name, item)| is_camera(name, item)) {
        chain.push(link(name, &item.table()?)?);
    }
    let poses: Vec<Vec<StatedPose>> = (0..chain.len()).map(|i| poses(&chain, i)).collect();
    let cameras = chain.into_iter().zip(poses).map(|(link, poses)| Calibration { poses, ..link.camera });
    Ok(cameras.collect())
}

fn link(name: &str, table: &Table<'_>) -> Result<Link, Fault> {
    const INTRINSICS: &str = "intrinsics: [500.0, 500.0, 320.0, 240.0]";
    let (model, intrinsics) =
        (table.require("camera_model", "camera_model: pinhole")?, table.require("intrinsics", INTRINSICS)?);
    let xi = match model.text()? {
        "pinhole" => None,
        "omni" => Some(()),
        other => return Err(unknown(&model, "camera model", other, ["pinhole", "omni"].into_iter())),
    };
    let (xi, matrix) = match xi {
        None => (None, intrinsics.array::<4>("fu, fv, pu, pv")?),
        Some(()) => {
            let [xi, matrix @ ..] = intrinsics.array::<5>("ξ, fu, fv, pu, pv")?;
            (Some(xi), matrix)
        }
    };
    let projection = projection(table, xi.map(|xi| (&intrinsics, xi)))?;
    let resolution = table.require("resolution", "resolution: [640, 480]")?.resolution()?;
    let pose = |key| table.get(key).map(|item| item.pose()).transpose();
    Ok(Link {
        from_previous: pose("T_cn_cnm1")?,
        from_imu: pose("T_cam_imu")?,
        camera: Calibration {
            name: name.to_owned(),
            intrinsics: at_centres(&intrinsics, matrix, 0.0)?,
            projection,
            resolution: Some(resolution),
            poses: Vec::new(),
            warnings: unused(&table.unread(&WITHOUT_MEANING)).into_iter().collect(),
        },
    })
}

fn projection(table: &Table<'_>, xi: Option<(&Item<'_>, f64)>) -> Result<Projection, Fault> {
    let model = table.require("distortion_model", "distortion_model: radtan")?;
    let coefficients = || table.require("distortion_coeffs", "distortion_coeffs: [-0.1, 0.01, 0.0, 0.0]");
    match (model.text()?, xi) {
        ("radtan", None) => brown_conrady(&coefficients()?, &coefficients()?.array::<4>("k1, k2, p1, p2")?),
        ("radtan", Some((item, xi))) => omnidirectional(item, xi, coefficients()?.array("k1, k2, p1, p2")?),
        ("equidistant", None) => kannala_brandt(&coefficients()?),
        ("equidistant", Some(_)) => Err(model
            .fault("omni with equidistant distortion is not rendered by photosite")
            .help("calibrate omni-radtan")),
        ("none", xi) => {
            if let Some(given) =
                table.get("distortion_coeffs").filter(|item| item.numbers().is_ok_and(|c| !c.is_empty()))
            {
                return Err(given.fault("are given for a lens without distortion"));
            }
            xi.map_or(Ok(Projection::Perspective), |(item, xi)| omnidirectional(item, xi, [0.0; 4]))
        }
        (other, _) => Err(unknown(&model, "distortion model", other, ["radtan", "equidistant", "none"].into_iter())),
    }
}

/// Poses of a camera of a chain: from each camera that is linked to it, itself among them, and from the IMU.
fn poses(chain: &[Link], index: usize) -> Vec<StatedPose> {
    let of_cameras = (0..chain.len()).filter_map(|other| {
        let from_other = from_camera(chain, other, index)?;
        // The other camera's own axes become glTF's, which make it stand upright.
        let to_frame = to_frame(&(from_other * half_turn()));
        Some(StatedPose { name: chain[other].camera.name.clone(), to_frame })
    });
    let imu = chain[index].from_imu.or_else(|| {
        (0..chain.len()).find_map(|other| Some(from_camera(chain, other, index)? * chain[other].from_imu?))
    });
    let imu = imu.map(|from_imu| StatedPose { name: "imu".to_owned(), to_frame: to_frame(&from_imu) });
    of_cameras.chain(imu).collect()
}

/// Transform from a camera's coordinates to another's, along the chain or by the IMU.
fn from_camera(chain: &[Link], from: usize, to: usize) -> Option<DAffine3> {
    let along = |from: usize, to: usize| {
        chain[from + 1..=to].iter().try_fold(DAffine3::IDENTITY, |pose, link| Some(link.from_previous? * pose))
    };
    let by_chain = if from <= to { along(from, to) } else { along(to, from).map(|pose| pose.inverse()) };
    by_chain.or_else(|| Some(chain[to].from_imu? * chain[from].from_imu?.inverse()))
}
