//! Arrays for NumPy, which get the memory of the library's pictures where these have one vector.

use std::path::PathBuf;

use numpy::{Element, IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray3};
use photosite::image::Channel;
use photosite::image::Planes;
use photosite::io::exr::write_exr;
use photosite::io::output::write_whole;
use photosite::{Invalid, Result};
use pyo3::prelude::*;

use crate::work::{How, work};

/// A row of numbers.
pub(crate) type Numbers<'py> = Bound<'py, PyArray1<f64>>;

/// Numbers of pixels, row by row, as an array (rows, columns, components); of one component (rows, columns).
pub(crate) fn of_pixels<'py, T: Element>(
    py: Python<'py>,
    [rows, columns, components]: [usize; 3],
    numbers: Vec<T>,
) -> PyResult<Bound<'py, PyAny>> {
    let flat = numbers.into_pyarray(py);
    Ok(match components {
        1 => flat.reshape([rows, columns])?.into_any(),
        _ => flat.reshape([rows, columns, components])?.into_any(),
    })
}

/// Planes as an array (rows, columns, channels), also where there is a single one.
pub(crate) fn of_stack<'py>(py: Python<'py>, planes: &Planes) -> PyResult<Bound<'py, PyAny>> {
    let channels = planes.channels();
    let [rows, columns, count] = [planes.height(), planes.width(), channels.len()];
    let numbers = py.detach(|| {
        let mut numbers = vec![0.0f32; rows * columns * count];
        for (i, channel) in channels.iter().enumerate() {
            numbers[i..].iter_mut().step_by(count).zip(&channel.data).for_each(|(to, &value)| *to = value);
        }
        numbers
    });
    Ok(numbers.into_pyarray(py).reshape([rows, columns, count])?.into_any())
}

/// Planes as an array (rows, columns, channels); a single one as (rows, columns).
pub(crate) fn of_planes<'py>(py: Python<'py>, planes: Planes) -> PyResult<Bound<'py, PyAny>> {
    let [rows, columns, count] = [planes.height(), planes.width(), planes.channels().len()];
    let mut channels = planes.into_channels();
    let numbers = py.detach(|| match count {
        1 => channels.swap_remove(0).data,
        _ => (0..rows * columns).flat_map(|i| channels.iter().map(move |channel| channel.data[i])).collect(),
    });
    of_pixels(py, [rows, columns, count], numbers)
}

/// The planes of an array (rows, columns, channels) of any strides.
pub(crate) fn to_planes(numbers: &PyReadonlyArray3<'_, f32>, names: Vec<String>) -> Result<Planes, Invalid> {
    let numbers = numbers.as_array();
    let &[height, width, _] = numbers.shape() else { unreachable!("an array of three axes") };
    let plane = |(index, name): (usize, String)| {
        let data = numbers.index_axis(numpy::ndarray::Axis(2), index).iter().copied().collect();
        Channel { name, data }
    };
    Planes::new(width, height, names.into_iter().enumerate().map(plane).collect())
}

/// Writes an array (rows, columns, 3) of linear RGB as an EXR file.
#[pyfunction]
pub(crate) fn write_rgb(py: Python<'_>, path: PathBuf, numbers: PyReadonlyArray3<'_, f32>) -> PyResult<()> {
    let planes = to_planes(&numbers, ["R", "G", "B"].map(str::to_owned).to_vec());
    work(py, How::default(), |_| {
        let planes = planes.map_err(|invalid| invalid.in_file(&path))?;
        write_whole(&path, |to| write_exr(&planes, &[], to))
    })
}

/// Rows of numbers as an array (rows, N).
pub(crate) fn of_rows<const N: usize>(
    py: Python<'_>,
    rows: impl ExactSizeIterator<Item = [f64; N]>,
) -> PyResult<Bound<'_, PyAny>> {
    let count = rows.len();
    let numbers: Vec<f64> = rows.flatten().collect();
    Ok(numbers.into_pyarray(py).reshape([count, N])?.into_any())
}
