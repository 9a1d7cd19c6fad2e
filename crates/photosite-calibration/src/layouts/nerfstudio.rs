//! Nerfstudio's layout ([Nerfstudio](photosite_core::references#nerfstudio)):
//!
//! ```text
//! transforms.json
//! images/CAMERA-000000.png
//! depths/CAMERA-000000.npy
//! ```
//!
//! `transform_matrix` leads from the camera (x right, y up, looking along −z) to a world whose z points up, which
//! `applied_transform` makes of glTF's. Lengths are metres. Pixels are counted from the corner of the first one. Lenses
//! are stated once where all images have the same, else with each image. Depth is along the axis, in mm, 0 for no
//! surface; it is written where the images have ground truth of it.
//!
//! For a camera that moves while its rows are exposed one after the other, `transform_matrix` is the pose of the middle
//! of the image, as in ground truth. `transform_matrix_start` and `transform_matrix_end` are the poses in the middle of
//! the exposure of the top and of the bottom row. With `rolling_shutter`, a, b, c, d, these are the keys of instant-ngp
//! ([InstantNgp](photosite_core::references#instantngp)), which NVIDIA's loaders for 3DGUT
//! ([Gut3d](photosite_core::references#gut3d)) take over: at u, v from 0 to 1 across the image and a random number r
//! the pose is that of the part a + b·u + c·v + d·r of the way from start to end. `shutter_type` is a name of the
//! shutters of 3DGUT, to which gsplat gives start and end as `viewmats` and `viewmats_rs`.

use glam::{DAffine3, DMat3, DVec3};
use serde_json::{Map, Value, json};

use super::super::camera_files::{CalibratedCamera, rows};
use super::image_set::{ImageSet, LayoutFiles, RollingShutter, Shot, is_same_lens};
use crate::truth::TruthLayer;
use photosite_core::projection::{BrownConrady, CalibrationModel, Intrinsics};
use photosite_core::{Invalid, Result};

/// Rotation from y up to z up.
const TO_Z_UP: DMat3 =
    DMat3::from_cols(DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.0, -1.0, 0.0));

pub(super) fn write(set: &ImageSet, files: &mut dyn LayoutFiles) -> Result<()> {
    let Some(first) = set.shots.first() else { return Ok(()) };
    let mut lenses = Vec::new();
    for shot in &set.shots {
        lenses.push(lens(&shot.calibrated).map_err(|invalid| set.error(invalid))?);
    }
    let model = lenses[0].model;
    if let Some(i) = lenses.iter().position(|lens| lens.model != model) {
        let message = format!(
            "Nerfstudio has one camera_model for all images, but {} is {}, {} {model}",
            set.shots[i].calibrated.name, lenses[i].model, first.calibrated.name,
        );
        return Err(
            set.error(Invalid::new("lens", message).help("lay out a data set whose cameras have lenses of one kind"))
        );
    }
    let is_one = set.shots.iter().all(|shot| is_same_lens(&shot.calibrated, &first.calibrated));
    let has_depth = files.has_truth(first, &[TruthLayer::Depth])?;
    let shutters: Vec<Option<[f64; 4]>> = set.shots.iter().map(rolling_shutter).collect();
    // One for all images, in instant-ngp as well.
    let shutter = shutters[0].filter(|_| shutters.iter().all(|other| other == &shutters[0]));
    if shutter.is_none() && set.shots.iter().any(|shot| shot.is_skewed) {
        files.warn(if set.shots.iter().any(|shot| shot.shutter.as_ref().is_some_and(|shutter| !shutter.is_downwards)) {
            "the sensor takes its rows from the middle outwards, which transforms.json cannot describe: each image has \
             but one pose"
        } else if shutters.iter().any(Option::is_none) {
            "things move while rows are exposed one after another, and transforms.json tells of cameras that do so in all \
             images alone: the images have one pose for all of their rows, or no rolling_shutter"
        } else {
            "exposure times differ from image to image: transforms.json is without rolling_shutter, which is one for all"
        });
    }
    let mut frames = Vec::new();
    for (i, (shot, lens)) in set.shots.iter().zip(&lenses).enumerate() {
        let name = format!("{}-{:06}", shot.calibrated.name, shot.frame);
        let mut frame = Map::new();
        let image = format!("images/{name}.png");
        files.copy_image(&image, shot)?;
        frame.insert("file_path".to_owned(), image.into());
        if has_depth {
            let depth = format!("depths/{name}.npy");
            let planes = files.truth(shot, &[TruthLayer::Depth])?;
            let mm = |m: &f32| if m.is_finite() { (f64::from(*m) * 1e3) as f32 } else { 0.0 };
            let values: Vec<f32> = planes.plane("depth").unwrap_or_default().iter().map(mm).collect();
            files.write_npy(&depth, shot.calibrated.resolution, &values)?;
            frame.insert("depth_file_path".to_owned(), depth.into());
        }
        frame.insert("transform_matrix".to_owned(), json!(matrix(&shot.calibrated.to_world)));
        if let Some(RollingShutter { rows: [top, bottom], .. }) =
            shot.shutter.as_ref().filter(|_| shutters[i].is_some())
        {
            frame.insert("transform_matrix_start".to_owned(), json!(matrix(top)));
            frame.insert("transform_matrix_end".to_owned(), json!(matrix(bottom)));
            frame.insert("shutter_type".to_owned(), "ROLLING_TOP_TO_BOTTOM".into());
        }
        if !is_one {
            frame.extend(lens.keys.clone());
        }
        frame.insert("camera".to_owned(), shot.calibrated.name.clone().into());
        frame.insert("frame".to_owned(), shot.frame.into());
        frame.insert("time_s".to_owned(), shot.since_epoch_s().into());
        frames.push(Value::Object(frame));
    }
    let mut all = Map::new();
    all.insert("camera_model".to_owned(), model.into());
    all.insert("orientation_override".to_owned(), "none".into());
    if is_one {
        all.extend(lenses[0].keys.clone());
    }
    if let Some(shutter) = shutter {
        all.insert("rolling_shutter".to_owned(), json!(shutter));
    }
    all.insert("applied_transform".to_owned(), json!(&rows(&DAffine3::from_mat3(TO_Z_UP))[..3]));
    all.insert("frames".to_owned(), frames.into());
    let text = serde_json::to_string_pretty(&all).unwrap_or_default();
    files.write_text("transforms.json", &(text + "\n"))
}

/// Lens in the keys of the format.
struct Lens {
    model: &'static str,
    keys: Map<String, Value>,
}

fn lens(camera: &CalibratedCamera) -> Result<Lens, Invalid> {
    let (model, coefficients) = match camera.projection.calibration_model() {
        Some(CalibrationModel::Pinhole) => ("OPENCV", vec![("k1", 0.0), ("k2", 0.0), ("p1", 0.0), ("p2", 0.0)]),
        Some(CalibrationModel::BrownConrady(BrownConrady {
            k: [k1, k2, k3, 0.0, 0.0, 0.0],
            p: [p1, p2],
            s: [0.0, 0.0, 0.0, 0.0],
        })) => ("OPENCV", vec![("k1", k1), ("k2", k2), ("k3", k3), ("p1", p1), ("p2", p2)]),
        Some(CalibrationModel::KannalaBrandt { k: [k1, k2, k3, k4] }) => {
            ("OPENCV_FISHEYE", vec![("k1", k1), ("k2", k2), ("k3", k3), ("k4", k4)])
        }
        Some(CalibrationModel::BrownConrady(_) | CalibrationModel::Omnidirectional { .. }) | None => {
            let instead = "take brown-conrady with k of up to three and without s, or kannala-brandt";
            return Err(camera.no_model("Nerfstudio's", instead));
        }
    };
    camera.without_skew("Nerfstudio's")?;
    let (Intrinsics { fx, fy, cx, cy, .. }, [width, height]) = (camera.intrinsics, camera.resolution);
    let mut keys = Map::new();
    keys.extend([("w", width), ("h", height)].map(|(key, value)| (key.to_owned(), value.into())));
    let numbers = [("fl_x", fx), ("fl_y", fy), ("cx", cx), ("cy", cy)].into_iter().chain(coefficients);
    keys.extend(numbers.map(|(key, value)| (key.to_owned(), value.into())));
    Ok(Lens { model, keys })
}

/// Camera → world matrix with z up, row by row.
fn matrix(to_world: &DAffine3) -> [[f64; 4]; 4] {
    rows(&(DAffine3::from_mat3(TO_Z_UP) * *to_world))
}

/// Coefficients a, b, c, d of `rolling_shutter`. Row y of n is at v = (y + ½)/n, and its middle at the part y/(n − 1)
/// of the way.
fn rolling_shutter(shot: &Shot) -> Option<[f64; 4]> {
    let shutter = shot.shutter.as_ref().filter(|shutter| shutter.is_downwards)?;
    let rows = f64::from(shot.calibrated.resolution[1]);
    let exposure = shutter.exposure;
    Some([-0.5 / (rows - 1.0) - 0.5 * exposure, 0.0, rows / (rows - 1.0), exposure])
}
