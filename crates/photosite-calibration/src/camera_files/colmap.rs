//! COLMAP's text models: `cameras.txt`, `images.txt` and `points3D.txt`. Pixels are counted as photosite does.

use std::fmt::Write;

use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::{CalibratedCamera, opencv_pose};
use photosite_core::Invalid;
use photosite_core::projection::{BrownConrady, CalibrationModel, Intrinsics};

/// Image that a camera took.
#[derive(Clone, Debug, PartialEq)]
pub struct ColmapImage {
    /// File name relative to the folder of images.
    pub name: String,
    /// Index of the camera.
    pub camera: usize,
    /// Camera → world with the axes of glTF, m.
    pub to_world: DAffine3,
    /// Observed points: pixel in photosite's coordinates, and number of the point.
    pub points: Vec<(DVec2, usize)>,
}

/// Point that images show.
#[derive(Clone, Debug, PartialEq)]
pub struct ColmapPoint {
    /// Number of the point.
    pub number: usize,
    /// Position in the world, m.
    pub world: DVec3,
    /// Track: index of each image that shows the point, and index of the point among that image's observations.
    pub track: Vec<(usize, usize)>,
}

/// Text of `cameras.txt`; cameras are numbered from 1.
pub fn colmap_cameras(cameras: &[CalibratedCamera]) -> Result<String, Invalid> {
    let mut text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n".to_owned();
    for (i, camera) in cameras.iter().enumerate() {
        camera.without_skew("COLMAP")?;
        let Intrinsics { fx, fy, cx, cy, .. } = camera.intrinsics;
        let (model, coefficients) = match camera.projection.calibration_model() {
            Some(CalibrationModel::Pinhole) => ("PINHOLE", Vec::new()),
            Some(CalibrationModel::BrownConrady(BrownConrady {
                k: [k1, k2, 0.0, 0.0, 0.0, 0.0],
                p: [p1, p2],
                s: [0.0, 0.0, 0.0, 0.0],
            })) => ("OPENCV", vec![k1, k2, p1, p2]),
            Some(CalibrationModel::BrownConrady(BrownConrady {
                k: [k1, k2, rest @ ..],
                p: [p1, p2],
                s: [0.0, 0.0, 0.0, 0.0],
            })) => ("FULL_OPENCV", [&[k1, k2, p1, p2], rest.as_slice()].concat()),
            Some(CalibrationModel::KannalaBrandt { k }) => ("OPENCV_FISHEYE", k.to_vec()),
            Some(CalibrationModel::BrownConrady(_) | CalibrationModel::Omnidirectional { .. }) | None => {
                return Err(camera.no_model("COLMAP", "take brown-conrady without s, or kannala-brandt"));
            }
        };
        let [width, height] = camera.resolution;
        let _ = write!(text, "{} {model} {width} {height} {fx} {fy} {cx} {cy}", i + 1);
        coefficients.iter().for_each(|c| text += &format!(" {c}"));
        text.push('\n');
    }
    Ok(text)
}

/// Text of `images.txt`; images are numbered from 1.
pub fn colmap_images(images: &[ColmapImage]) -> String {
    let mut text =
        "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME, then a line of X, Y, POINT3D_ID\n".to_owned();
    for (i, ColmapImage { name, camera, to_world, points }) in images.iter().enumerate() {
        let from_world = opencv_pose(to_world).inverse();
        let DQuat { x, y, z, w } = DQuat::from_mat3(&from_world.matrix3);
        let [tx, ty, tz] = from_world.translation.to_array();
        let _ = writeln!(text, "{} {w} {x} {y} {z} {tx} {ty} {tz} {} {name}", i + 1, camera + 1);
        let points: Vec<String> =
            points.iter().map(|(pixel, number)| format!("{} {} {number}", pixel.x, pixel.y)).collect();
        text += &points.join(" ");
        text.push('\n');
    }
    text
}

/// Text of `points3D.txt`: grey points without error.
pub fn colmap_points(points: &[ColmapPoint]) -> String {
    let mut text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n".to_owned();
    for ColmapPoint { number, world: DVec3 { x, y, z }, track } in points {
        let _ = write!(text, "{number} {x} {y} {z} 128 128 128 0");
        track.iter().for_each(|(image, point)| text += &format!(" {} {point}", image + 1));
        text.push('\n');
    }
    text
}
