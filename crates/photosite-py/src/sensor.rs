//! Sensors alone, exposed to light that somebody else has computed.

use std::path::{Path, PathBuf};

use numpy::{IntoPyArray, PyReadonlyArray1, PyReadonlyArray3};
use photosite::capture::{NamedSensor, read_named_sensor};
use photosite::pipeline::{ImageScale, Light};
use photosite::sensor::{ImageUnit, SensorModel};
use photosite::spectrum::{Outside, Spectrum, illuminant};
use photosite::{Invalid, Sandbox};
use pyo3::prelude::*;

use crate::array::{Numbers, to_planes};
use crate::error::{PYTHON, raise};
use crate::shot::Shot;
use crate::work::{How, warn, work};

/// A sensor by the name of a preset or the path of a sensor file, with changes to its keys.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Sensor {
    model: SensorModel,
    values: String,
}

#[pymethods]
impl Sensor {
    #[new]
    fn new(py: Python<'_>, name: &str, overrides: Vec<String>) -> PyResult<Self> {
        let read = read_named_sensor(&Sandbox::default(), name, &overrides);
        let NamedSensor { model, values, warnings } = read.map_err(|error| raise(py, error))?;
        warn(py, warnings)?;
        Ok(Self { model, values: values.to_string() })
    }

    /// Values of all its keys, as JSON.
    fn values(&self) -> &str {
        &self.values
    }

    fn name(&self) -> &str {
        &self.model.name
    }

    /// Columns and rows of the sensor.
    fn resolution(&self) -> [usize; 2] {
        self.model.resolution
    }

    /// Pixel pitch, horizontal and vertical, m.
    fn pixel_pitch_m(&self) -> [f64; 2] {
        self.model.pixel_pitch_m
    }

    fn channels(&self) -> Vec<String> {
        self.model.cfa.channels().to_vec()
    }

    /// Responses of the channels: for each its name, wavelengths, nm, and electrons a second that W·m⁻²·nm⁻¹ frees in a
    /// pixel.
    fn responses<'py>(&self, py: Python<'py>) -> Vec<(String, Numbers<'py>, Numbers<'py>)> {
        let arrays = |(name, response): (String, Spectrum)| {
            let (wavelengths, values) = table(py, &response);
            (name, wavelengths, values)
        };
        self.model.responses().into_iter().map(arrays).collect()
    }
}

/// Table of wavelengths, nm, and values.
type Table<'py> = (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>);

/// The spectrum of a table.
fn spectrum(py: Python<'_>, table: Option<Table<'_>>) -> PyResult<Option<Spectrum>> {
    let Some((wavelengths, values)) = table else { return Ok(None) };
    let spectrum = Spectrum::from_samples(wavelengths.as_slice()?, values.as_slice()?, Outside::Zero);
    let spectrum = spectrum.map_err(|invalid| raise(py, invalid.within("illuminant").in_file(Path::new(PYTHON))));
    spectrum.map(Some)
}

/// Exposes a sensor to irradiance, (rows, columns, bands) in W·m⁻²·nm⁻¹.
#[pyfunction]
pub(crate) fn expose_irradiance(
    py: Python<'_>,
    irradiance: PyReadonlyArray3<'_, f32>,
    wavelengths_nm: Vec<f64>,
    white: Option<Table<'_>>,
    overrides: Vec<String>,
    frames: u32,
    threads: Option<usize>,
) -> PyResult<Vec<Shot>> {
    let names = wavelengths_nm.iter().map(f64::to_string).collect();
    let bands = to_planes(&irradiance, names).map_err(|invalid| raise(py, invalid.in_file(Path::new(PYTHON))))?;
    let white = spectrum(py, white)?;
    work(py, How { threads, progress: None }, |monitor| {
        let light = Light::of_irradiance(Path::new(PYTHON), bands, white.as_ref(), &overrides)?;
        Shot::series(&light, frames, monitor)
    })
}

/// Exposes a sensor to planes of pixel values, (rows, columns, channels), of which 1 stands for `one` of a unit.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "numbers, what they are, and how they are exposed")]
pub(crate) fn expose_planes(
    py: Python<'_>,
    numbers: PyReadonlyArray3<'_, f32>,
    channels: Vec<String>,
    unit: &str,
    one: f64,
    wavelength_nm: Option<f64>,
    white: Option<Table<'_>>,
    overrides: Vec<String>,
    frames: u32,
    threads: Option<usize>,
) -> PyResult<Vec<Shot>> {
    let planes = to_planes(&numbers, channels).map_err(|invalid| raise(py, invalid.in_file(Path::new(PYTHON))))?;
    let unit = match (unit, wavelength_nm) {
        ("electrons", _) => ImageUnit::Electrons,
        ("full-well", _) => ImageUnit::FullWell,
        ("lux", _) => ImageUnit::Lux,
        ("irradiance", Some(wavelength_nm)) => ImageUnit::Irradiance { wavelength_nm },
        _ => {
            let invalid = Invalid::new("unit", format!("{unit:?} is not a unit of light on a sensor"));
            let help = "write \"electrons\", \"full-well\", \"lux\", or \"irradiance\" with wavelength_nm";
            return Err(raise(py, invalid.help(help).in_file(Path::new(PYTHON))));
        }
    };
    let white = spectrum(py, white)?;
    work(py, How { threads, progress: None }, |monitor| {
        let scale = ImageScale { unit, one, is_linear: true };
        let light = Light::of_planes(Path::new(PYTHON), &planes, &scale, white.as_ref(), &overrides)?;
        Shot::series(&light, frames, monitor)
    })
}

/// Exposes light that a render has left in a folder, or one of its files.
#[pyfunction]
pub(crate) fn expose_stored(
    py: Python<'_>,
    path: PathBuf,
    overrides: Vec<String>,
    frames: u32,
    threads: Option<usize>,
) -> PyResult<Vec<Shot>> {
    work(py, How { threads, progress: None }, |monitor| {
        Shot::series(&Light::read(&Sandbox::default(), &path, &overrides)?, frames, monitor)
    })
}

/// The spectrum of a light by its name: wavelengths, nm, and relative values.
#[pyfunction]
pub(crate) fn illuminant_spectrum<'py>(py: Python<'py>, name: &str) -> PyResult<(Numbers<'py>, Numbers<'py>)> {
    let spectrum = illuminant::illuminant(name).ok_or_else(|| {
        let known = illuminant::names().collect::<Vec<_>>().join(", ");
        let invalid = Invalid::new("illuminant", format!("there is no light {name:?}"));
        raise(py, invalid.help(format!("the lights are {known}")).in_file(Path::new(PYTHON)))
    })?;
    Ok(table(py, &spectrum))
}

/// Wavelengths, nm, and values of a spectrum.
fn table<'py>(py: Python<'py>, spectrum: &Spectrum) -> (Numbers<'py>, Numbers<'py>) {
    let (wavelengths, values): (Vec<f64>, Vec<f64>) = spectrum.iter().unzip();
    (wavelengths.into_pyarray(py), values.into_pyarray(py))
}
