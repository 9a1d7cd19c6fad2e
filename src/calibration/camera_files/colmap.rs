//! COLMAP's text models: `cameras.txt` and `images.txt`. Pixels are counted as photosite does.

use std::fmt::Write;

use glam::{DAffine3, DQuat};

use super::{CalibratedCamera, opencv_pose};
use crate::Invalid;
use crate::optics::{BrownConrady, Intrinsics, Projection};

/// A picture that a camera took.
#[derive(Clone, Debug, PartialEq)]
pub struct ColmapImage {
    /// File name relative to the folder of images.
    pub name: String,
    /// Which of the cameras, counted from 0.
    pub camera: usize,
    /// Camera → world with the axes of glTF, m.
    pub to_world: DAffine3,
}

/// `cameras.txt`: cameras are numbered from 1.
pub fn colmap_cameras(cameras: &[CalibratedCamera]) -> Result<String, Invalid> {
    let mut text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n".to_owned();
    for (i, camera) in cameras.iter().enumerate() {
        camera.without_skew("COLMAP")?;
        let Intrinsics { fx, fy, cx, cy, .. } = camera.intrinsics;
        let (model, coefficients) = match camera.projection {
            Projection::Perspective => ("PINHOLE", Vec::new()),
            Projection::BrownConrady(BrownConrady {
                k: [k1, k2, 0.0, 0.0, 0.0, 0.0],
                p: [p1, p2],
                s: [0.0, 0.0, 0.0, 0.0],
            }) => ("OPENCV", vec![k1, k2, p1, p2]),
            Projection::BrownConrady(BrownConrady { k: [k1, k2, rest @ ..], p: [p1, p2], s: [0.0, 0.0, 0.0, 0.0] }) => {
                ("FULL_OPENCV", [&[k1, k2, p1, p2], rest.as_slice()].concat())
            }
            Projection::KannalaBrandt { k } => ("OPENCV_FISHEYE", k.to_vec()),
            Projection::BrownConrady(_)
            | Projection::Polynomial { .. }
            | Projection::Division { .. }
            | Projection::Equirectangular
            | Projection::Omnidirectional { .. } => {
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

/// `images.txt`: images are numbered from 1; none has points.
pub fn colmap_images(images: &[ColmapImage]) -> String {
    let mut text = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME, then a line of points\n".to_owned();
    for (i, ColmapImage { name, camera, to_world }) in images.iter().enumerate() {
        let from_world = opencv_pose(to_world).inverse();
        let DQuat { x, y, z, w } = DQuat::from_mat3(&from_world.matrix3);
        let [tx, ty, tz] = from_world.translation.to_array();
        text += &format!("{} {w} {x} {y} {z} {tx} {ty} {tz} {} {name}\n\n", i + 1, camera + 1);
    }
    text
}
