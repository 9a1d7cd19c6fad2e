//! EMVA 1288: image sets of a sensor, and the figures that they show.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArrayMethods};
use photosite::Sandbox;
use photosite::capture::{NamedSensor, read_named_sensor};
use photosite::characterisation::camera_fit::{KnownFacts, MapNames};
use photosite::characterisation::effects_left_out;
use photosite::emva1288::{
    FitRequest, MeasuredChannel, SetPlan, SetRequest, evaluate_descriptor, evaluate_sets, fit_images, refuse_image_sets,
};
use photosite::io::formats::TIFF;
use photosite::pipeline::Event;
use photosite::units::{Celsius, Decibels, Seconds};
use pyo3::prelude::*;

use crate::work::{How, work};

/// Request of image sets: the images that are taken, and how.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Request {
    overrides: Vec<String>,
    like: Option<PathBuf>,
    channels: Option<Vec<String>>,
    wavelength_nm: Option<f64>,
    steps: u32,
    spatial: u32,
    saturation_time_s: Option<f64>,
    sweep_nm: Vec<f64>,
    temperatures_c: Vec<f64>,
    temperature_c: Option<f64>,
    gain_db: f64,
    size: Option<[usize; 2]>,
    seed: u64,
}

/// Takes the image sets of a sensor into a folder, and returns what the command prints as JSON.
#[pyfunction]
pub(crate) fn take_image_sets(
    py: Python<'_>,
    sensor: &str,
    folder: PathBuf,
    overwrite: bool,
    request: Request,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let sets = work(py, How { threads, progress }, |monitor| {
        let NamedSensor { model: sensor, warnings, .. } =
            read_named_sensor(&Sandbox::default(), sensor, &request.overrides)?;
        let like = request.like;
        let request = SetRequest {
            channels: request.channels,
            wavelength_nm: request.wavelength_nm,
            plan: None,
            steps: request.steps,
            spatial: request.spatial,
            saturation_time: request.saturation_time_s.map(Seconds),
            sweep_nm: request.sweep_nm,
            temperatures_c: request.temperatures_c,
            temperature: request.temperature_c.map(Celsius),
            gain: Decibels(request.gain_db),
            size: request.size,
            seed: request.seed,
            format: &TIFF,
            overrides: request.overrides,
        };
        let request = match &like {
            Some(set) => request.like(set)?,
            None => request,
        };
        let plan = SetPlan::new(&sensor, request)?;
        refuse_image_sets(&folder, overwrite)?;
        let left_out = effects_left_out(&sensor);
        let left_out = left_out
            .iter()
            .map(|key| format!("{key} is in the images, but not in the figures that are expected of them"));
        warnings.into_iter().chain(left_out).for_each(|warning| monitor.report(Event::Warning(&warning)));
        plan.take_into(&folder, overwrite, monitor)
    })?;
    Ok(serde_json::to_string(&sets).expect("plain values"))
}

/// Evaluates image sets of a folder, or of a descriptor: what the command prints as JSON, and its page.
#[pyfunction]
pub(crate) fn evaluate_image_sets(
    py: Python<'_>,
    path: PathBuf,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let report = work(py, How { threads, progress }, |monitor| {
        if path.is_dir() { evaluate_sets(&path, monitor) } else { evaluate_descriptor(&path, monitor) }
    })?;
    let channels: Vec<_> = report.channels.iter().map(MeasuredChannel::new).collect();
    Ok((serde_json::to_string(&channels).expect("plain values"), report.html()))
}

/// Facts about a camera that its images do not hold.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Known {
    channel: Option<String>,
    system_gain: Option<f64>,
    temperature_c: Option<f64>,
    pixel_pitch_um: Option<[f64; 2]>,
    wavelength_nm: Option<f64>,
}

/// Sensor fitted to the images of a camera.
#[pyclass(frozen)]
pub(crate) struct FittedCamera(photosite::emva1288::FittedCamera);

#[pymethods]
impl FittedCamera {
    /// What the command prints as JSON.
    fn report(&self) -> String {
        serde_json::to_string(&self.0.report()).expect("plain values")
    }

    /// Text of the sensor file, with maps beside the file of this name without its ending.
    #[pyo3(signature = (maps_of=None))]
    fn sensor_file(&self, maps_of: Option<&str>) -> String {
        self.0.sensor_file(&maps_of.map(MapNames::beside).unwrap_or_default())
    }

    /// Table of the defective pixels, as `defects.pixels` has it.
    fn defects_csv(&self) -> Option<String> {
        self.0.defects_csv()
    }

    /// Maps of responses, where there are flats, and of offsets in electrons, where they are the same at all gains:
    /// rows × columns.
    fn maps<'py>(&self, py: Python<'py>) -> PyResult<[Option<Bound<'py, PyAny>>; 2]> {
        let [width, height] = self.0.fit.size;
        let array = |values: Vec<f32>| Ok::<_, PyErr>(values.into_pyarray(py).reshape([height, width])?.into_any());
        let prnu = self.0.prnu_map().map(|values| array(values.to_vec())).transpose()?;
        Ok([prnu, self.0.dsnu_map_e().map(array).transpose()?])
    }
}

/// Fits a sensor to the images of a camera.
#[pyfunction]
pub(crate) fn fit_camera(
    py: Python<'_>,
    path: PathBuf,
    known: Known,
    maps: bool,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<FittedCamera> {
    let request = FitRequest {
        channel: known.channel,
        known: KnownFacts {
            system_gain: known.system_gain,
            temperature: known.temperature_c.map(Celsius),
            pixel_pitch_um: known.pixel_pitch_um,
            wavelength_nm: known.wavelength_nm,
        },
        maps,
    };
    work(py, How { threads, progress }, |monitor| fit_images(&path, &request, monitor)).map(FittedCamera)
}
