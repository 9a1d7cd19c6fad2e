//! Calibration targets, and where points appear.

use std::path::PathBuf;

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use photosite::calibration::targets::{Target as Drawing, TargetDescription, TargetKind};
use photosite::camera_projection::{CameraProjection, Space};
use photosite::capture::read_target;
use photosite::io::lock::Lock;
use photosite::io::target_file::{TargetFacts, target_files, write_target};
use pyo3::prelude::*;

use crate::array::of_rows;
use crate::capture::Capture;
use crate::work::{How, work};

/// A calibration target.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Target {
    description: TargetDescription,
    drawing: Drawing,
}

#[pymethods]
impl Target {
    /// A target of this kind, with `key=value` for its sizes.
    #[staticmethod]
    fn draw(py: Python<'_>, kind: &str, keys: Vec<String>) -> PyResult<Option<Self>> {
        let Some(kind) = TargetKind::ALL.iter().copied().find(|known| known.name() == kind) else { return Ok(None) };
        let (description, drawing) = work(py, How::default(), |_| read_target(kind, &keys))?;
        Ok(Some(Self { description, drawing }))
    }

    /// Names of the kinds, and their descriptions.
    #[staticmethod]
    fn kinds() -> Vec<(&'static str, &'static str)> {
        TargetKind::ALL.iter().map(|kind| (kind.name(), kind.summary())).collect()
    }

    /// Facts of the target: the contents of the command's JSON file.
    fn facts(&self) -> String {
        serde_json::to_string(&TargetFacts::new(&self.description, &self.drawing)).expect("plain values")
    }

    /// Points of the target in its own frame, m.
    fn points_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        of_rows(py, self.drawing.points.iter().map(|point| point.position_m.extend(0.0).to_array()))
    }

    /// Corners of the target's markers one after the other, m.
    fn corners_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let corners: Vec<_> = self.drawing.markers.iter().flat_map(|marker| marker.corners_m).collect();
        of_rows(py, corners.into_iter().map(|corner| corner.extend(0.0).to_array()))
    }

    /// Width and height of the sheet, m.
    fn size_m(&self) -> [f64; 2] {
        self.drawing.size_m().to_array()
    }

    /// Writes the sheet in the format that the extension asks for, in the place of older files.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        work(py, How::default(), |_| {
            target_files(&path)?;
            // Some are two files that belong together.
            let _lock = Lock::beside(&path)?;
            write_target(&path, &self.description, &self.drawing)
        })
    }
}

/// Projects points (N, 3) to pixels of a capture's image, (N, 2).
#[pyfunction]
pub(crate) fn project<'py>(
    py: Python<'py>,
    capture: &Capture,
    points: PyReadonlyArray2<'py, f64>,
    camera_space: bool,
) -> PyResult<Bound<'py, PyAny>> {
    debug_assert_eq!(points.shape()[1], 3, "points of three coordinates");
    let points = points.as_slice()?;
    let pixels: Vec<[f64; 2]> = work(py, How::default(), |_| {
        let sight = CameraProjection::new(capture.capture(), space(camera_space))?;
        let points = points.as_chunks::<3>().0.iter();
        Ok(points.map(|&point| sight.pixel(point)).collect())
    })?;
    of_rows(py, pixels.into_iter())
}

/// Directions in which pixels (N, 2) look, unit vectors (N, 3).
#[pyfunction]
pub(crate) fn unproject<'py>(
    py: Python<'py>,
    capture: &Capture,
    pixels: PyReadonlyArray2<'py, f64>,
    camera_space: bool,
) -> PyResult<Bound<'py, PyAny>> {
    debug_assert_eq!(pixels.shape()[1], 2, "pixels of two coordinates");
    let pixels = pixels.as_slice()?;
    let directions: Vec<[f64; 3]> = work(py, How::default(), |_| {
        let sight = CameraProjection::new(capture.capture(), space(camera_space))?;
        let pixels = pixels.as_chunks::<2>().0.iter();
        Ok(pixels.map(|&pixel| sight.direction(pixel)).collect())
    })?;
    of_rows(py, directions.into_iter())
}

fn space(camera_space: bool) -> Space {
    if camera_space { Space::Camera } else { Space::World }
}
