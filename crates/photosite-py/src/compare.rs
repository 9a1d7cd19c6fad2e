//! Comparison of images.

use std::path::{Path, PathBuf};

use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use photosite::image::{Channel, Planes};
use photosite::io::image_file::{interleaved, read_image_file};
use photosite::pipeline::Event;
use photosite::raw::Pixels;
use photosite::report::ComparisonReport;
use photosite::validation::{ComparedImage, ComparisonSettings, Limits, false_colour};
use photosite::{Error, Invalid};
use pyo3::prelude::*;

use crate::array::of_pixels;
use crate::error::{PYTHON, in_arguments, raise};
use crate::raw::Raw;
use crate::work::{How, work};

/// Image to be compared, with variances where they are known.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct ComparedPicture(ComparedImage);

#[pymethods]
impl ComparedPicture {
    /// Reads a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf, masked: bool) -> PyResult<Self> {
        work(py, How::default(), |monitor| {
            let image = read_image_file(&path, pixels(masked))?;
            image.said().for_each(|what| monitor.report(Event::Warning(&what)));
            Ok(image)
        })
        .map(Self)
    }

    /// A raw image.
    #[staticmethod]
    fn of_raw(py: Python<'_>, name: String, raw: &Raw, masked: bool) -> PyResult<Self> {
        let image = raw.image().clone();
        work(py, How::default(), |_| Ok(ComparedImage::from_raw(name, image.linear().into_owned(), pixels(masked))))
            .map(Self)
    }

    /// Image of pixel values (rows, columns, channels), with these names of channels, or those that a NPY file has.
    /// `maximum` is the largest value of integers.
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
        let image = match channels {
            None => interleaved(name, [width, height], count, numbers.iter().copied(), maximum),
            Some(names) => {
                let plane = |(first, name)| Channel {
                    name,
                    data: numbers.iter().skip(first).step_by(count).copied().collect(),
                };
                let mean = Planes::new(width, height, names.into_iter().enumerate().map(plane).collect());
                mean.map(|mean| ComparedImage {
                    full_scale: maximum.map(f64::from),
                    ..ComparedImage::plain(name, mean)
                })
            }
        };
        let image = image.map_err(|invalid| raise(py, invalid.in_file(Path::new(PYTHON))))?;
        // Arrays do not say what they count unless they are told to.
        Ok(Self(ComparedImage { unit, ..image }))
    }

    /// The image with one variance for all pixel values.
    fn with_constant_variance(&self, variance: f64) -> Self {
        Self(self.0.clone().with_constant_variance(variance))
    }

    /// The image with variances that another image holds.
    fn with_variances_from(&self, py: Python<'_>, other: &Self) -> PyResult<Self> {
        self.0.clone().with_variances_from(&other.0).map(Self).map_err(|invalid| raise(py, unfit(invalid)))
    }

    /// The image with variances from second moments of `samples` samples.
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

/// Error of arguments that do not fit together.
fn unfit(Invalid { message, help, .. }: Invalid) -> Error {
    Error::Usage { message, help }
}

/// Settings of a comparison.
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
    fn settings(&self) -> ComparisonSettings {
        let Self { channels, alpha, epsilon, peak, worst, .. } = self;
        ComparisonSettings { channels: channels.clone(), alpha: *alpha, epsilon: *epsilon, peak: *peak, worst: *worst }
    }
}

/// Compares two images: the object that `photosite compare --json` prints.
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

/// Image of the differences, with what it shows and within which range.
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
