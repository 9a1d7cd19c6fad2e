//! Comparison of pictures.

use std::path::{Path, PathBuf};

use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use photosite::image::{Channel, Planes};
use photosite::io::picture_file::{interleaved, read_picture_file};
use photosite::pipeline::Event;
use photosite::raw::Pixels;
use photosite::report::ComparisonReport;
use photosite::validation::{Limits, Picture, Settings, false_colour};
use photosite::{Error, Invalid};
use pyo3::prelude::*;

use crate::array::of_pixels;
use crate::error::{PYTHON, in_arguments, raise};
use crate::raw::Raw;
use crate::work::{How, work};

/// A picture to be compared, with variances where they are known.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct ComparedPicture(Picture);

#[pymethods]
impl ComparedPicture {
    /// Reads a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf, masked: bool) -> PyResult<Self> {
        work(py, How::default(), |monitor| {
            let picture = read_picture_file(&path, pixels(masked))?;
            picture.said().for_each(|what| monitor.report(Event::Warning(&what)));
            Ok(picture)
        })
        .map(Self)
    }

    /// A raw image.
    #[staticmethod]
    fn of_raw(py: Python<'_>, name: String, raw: &Raw, masked: bool) -> PyResult<Self> {
        let image = raw.image().clone();
        work(py, How::default(), |_| Ok(Picture::from_raw(name, image.linear().into_owned(), pixels(masked)))).map(Self)
    }

    /// Numbers (rows, columns, channels): of these names, or of those that channels of a NPY file have. `maximum` is the
    /// largest of whole numbers.
    #[staticmethod]
    fn of_array(
        py: Python<'_>,
        name: String,
        array: PyReadonlyArray3<'_, f32>,
        channels: Option<Vec<String>>,
        unit: Option<String>,
        maximum: Option<u16>,
    ) -> PyResult<Self> {
        let &[height, width, count] = array.shape() else { unreachable!("an array of three axes") };
        let numbers = array.as_slice()?;
        let picture = match channels {
            None => interleaved(name, [width, height], count, numbers.iter().copied(), maximum),
            Some(names) => {
                let plane = |(first, name)| Channel {
                    name,
                    data: numbers.iter().skip(first).step_by(count).copied().collect(),
                };
                let mean = Planes::new(width, height, names.into_iter().enumerate().map(plane).collect());
                mean.map(|mean| Picture {
                    name,
                    variance: Planes::zeros(width, height, [""; 0]),
                    mean,
                    unit: None,
                    full_scale: maximum.map(f64::from),
                    mosaic: None,
                    active_area: None,
                    stated: Vec::new(),
                    warnings: Vec::new(),
                    notes: Vec::new(),
                })
            }
        };
        let picture = picture.map_err(|invalid| raise(py, invalid.in_file(Path::new(PYTHON))))?;
        // Arrays do not say what they count unless they are told to.
        Ok(Self(Picture { unit, ..picture }))
    }

    /// The same with one variance for all numbers.
    fn with_constant_variance(&self, variance: f64) -> Self {
        Self(self.0.clone().with_constant_variance(variance))
    }

    /// The same with variances that another picture holds.
    fn with_variances_from(&self, py: Python<'_>, other: &Self) -> PyResult<Self> {
        self.0.clone().with_variances_from(&other.0).map(Self).map_err(|invalid| raise(py, unfit(invalid)))
    }

    /// The same with variances of second moments of so many samples.
    fn with_second_moments(&self, py: Python<'_>, samples: u64) -> PyResult<Self> {
        self.0.clone().with_second_moments(samples).map(Self).map_err(|invalid| raise(py, unfit(invalid)))
    }

    /// Names of the channels.
    fn channels(&self) -> Vec<String> {
        self.0.mean.channels().iter().map(|channel| channel.name.clone()).collect()
    }
}

fn pixels(masked: bool) -> Pixels {
    if masked { Pixels::All } else { Pixels::Active }
}

/// What is wrong with arguments that do not fit together.
fn unfit(Invalid { message, help, .. }: Invalid) -> Error {
    Error::Usage { message, help }
}

/// How to compare.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Comparing {
    channels: Option<Vec<String>>,
    alpha: f64,
    epsilon: f64,
    peak: Option<f64>,
    worst: usize,
    max_mean_difference_percent: Option<f64>,
    max_rmse: Option<f64>,
    max_relative_mse: Option<f64>,
}

impl Comparing {
    fn settings(&self) -> Settings {
        let Self { channels, alpha, epsilon, peak, worst, .. } = self;
        Settings { channels: channels.clone(), alpha: *alpha, epsilon: *epsilon, peak: *peak, worst: *worst }
    }
}

/// Compares two pictures: the object that `photosite compare --json` prints.
#[pyfunction]
pub(crate) fn compare(py: Python<'_>, a: &ComparedPicture, b: &ComparedPicture, how: Comparing) -> PyResult<String> {
    let limits = Limits {
        mean_difference_percent: how.max_mean_difference_percent,
        rmse: how.max_rmse,
        relative_mse: how.max_relative_mse,
    };
    let (a, b) = (&a.0, &b.0);
    let report = work(py, How::default(), |_| {
        let comparison = photosite::validation::compare(a, b, &how.settings()).map_err(unfit)?;
        Ok(ComparisonReport::new(comparison, [a, b], &limits, in_arguments))
    })?;
    Ok(serde_json::to_string(&report).expect("plain values"))
}

/// The differences as a picture, and what it shows within which range.
#[pyfunction]
pub(crate) fn difference_picture<'py>(
    py: Python<'py>,
    a: &ComparedPicture,
    b: &ComparedPicture,
    how: Comparing,
    range: Option<f64>,
) -> PyResult<(Bound<'py, PyAny>, &'static str, f64)> {
    let (a, b) = (&a.0, &b.0);
    let shown = work(py, How::default(), |_| false_colour(a, b, &how.settings(), range).map_err(unfit))?;
    let array = of_pixels(py, [shown.height, shown.width, 3], shown.pixels.into_flattened())?;
    Ok((array, shown.shown.name(), shown.range))
}
