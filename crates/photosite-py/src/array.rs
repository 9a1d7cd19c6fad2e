//! Arrays for NumPy, which get the memory of the library's pictures where these have one vector.

use numpy::{Element, IntoPyArray, PyArrayMethods};
use photosite::image::Planes;
use pyo3::prelude::*;

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

/// Planes as an array (rows, columns, channels); a single one as (rows, columns).
pub(crate) fn of_planes<'py>(py: Python<'py>, planes: Planes) -> PyResult<Bound<'py, PyAny>> {
    let [rows, columns, count] = [planes.height(), planes.width(), planes.channels().len()];
    let mut channels = planes.into_channels();
    let numbers = if count == 1 {
        channels.swap_remove(0).data
    } else {
        (0..rows * columns).flat_map(|i| channels.iter().map(move |channel| channel.data[i])).collect()
    };
    of_pixels(py, [rows, columns, count], numbers)
}
