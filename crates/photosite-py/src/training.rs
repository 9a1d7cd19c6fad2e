//! Facts of the images of a finished data set, for the files that training programs read.

use std::path::PathBuf;

use glam::DQuat;
use photosite::calibration::camera_files::ros_distortion;
use photosite::calibration::layouts::Shot;
use photosite::dataset::read_dataset;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::work::{How, work};

/// List of the images of a finished data set, in JSON, each with its folder, camera and frame, when it was taken, and
/// its camera in OpenCV's conventions, on the pixels of the image and in the middle of the exposure.
#[pyfunction]
pub(crate) fn shots(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    let set = work(py, How::default(), |_| read_dataset(&folder))?;
    Ok(Value::from_iter(set.shots.iter().map(facts)).to_string())
}

fn facts(shot: &Shot) -> Value {
    let camera = &shot.calibrated;
    let from_world = camera.from_world();
    let in_world = from_world.inverse();
    let DQuat { x, y, z, w } = DQuat::from_mat3(&in_world.matrix3).normalize();
    // Adding zero makes zeros of negative ones.
    let rotation = from_world.matrix3.transpose().to_cols_array().map(|x| x + 0.0);
    let (model, reason) = match ros_distortion(camera) {
        Ok((model, _)) => (Some(model), None),
        Err(invalid) => (None, Some(invalid.message)),
    };
    json!({
        "folder": shot.folder,
        "camera": camera.name,
        "frame": shot.frame,
        "stamp_ns": shot.stamp_ns,
        "resolution_px": camera.resolution,
        "camera_matrix": camera.matrix().as_chunks::<3>().0,
        "projection": camera.projection.name(),
        "distortion": camera.projection.coefficients(),
        "xi": camera.projection.xi(),
        "rotation": rotation.as_chunks::<3>().0,
        "translation_m": from_world.translation.to_array().map(|x| x + 0.0),
        "in_world": { "translation_m": in_world.translation.to_array(), "quaternion_xyzw": [x, y, z, w] },
        "ros": { "model": model, "reason": reason },
    })
}
