//! Arrays for NumPy, which get the memory of the library's images where these have one vector.

use std::path::PathBuf;

use numpy::{Element, IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray3};
use photosite::image::{Channel, Planes};
use photosite::io::exr::write_exr;
use photosite::io::output::write_whole;
use photosite::{Invalid, Result};
use pyo3::prelude::*;

use crate::work::{How, work};

/// Array of numbers.
pub(crate) type Numbers<'py> = Bound<'py, PyArray1<f64>>;

/// Array of pixel values, row by row, (rows, columns, components); of one component (rows, columns).
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
    let shape = [planes.height(), planes.width(), planes.channels().len()];
    let numbers = py.detach(|| interleaved(planes.channels()));
    Ok(numbers.into_pyarray(py).reshape(shape)?.into_any())
}

/// Planes as an array (rows, columns, channels); a single one as (rows, columns), which gets its memory.
pub(crate) fn of_planes<'py>(py: Python<'py>, planes: Planes) -> PyResult<Bound<'py, PyAny>> {
    let shape @ [.., count] = [planes.height(), planes.width(), planes.channels().len()];
    let mut channels = planes.into_channels();
    let numbers = if count == 1 { channels.swap_remove(0).data } else { py.detach(|| interleaved(&channels)) };
    of_pixels(py, shape, numbers)
}

/// Pixel values of all channels, pixel by pixel.
fn interleaved(channels: &[Channel]) -> Vec<f32> {
    let count = channels.len();
    let mut numbers = vec![0.0f32; channels.iter().map(|channel| channel.data.len()).sum()];
    for (i, channel) in channels.iter().enumerate() {
        numbers[i..].iter_mut().step_by(count).zip(&channel.data).for_each(|(to, &value)| *to = value);
    }
    numbers
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

/// Array of rows of numbers, (rows, N).
pub(crate) fn of_rows<const N: usize>(
    py: Python<'_>,
    rows: impl ExactSizeIterator<Item = [f64; N]>,
) -> PyResult<Bound<'_, PyAny>> {
    let count = rows.len();
    let numbers: Vec<f64> = rows.flatten().collect();
    Ok(numbers.into_pyarray(py).reshape([count, N])?.into_any())
}
