//! Light that is traced, and folders that renders fill.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::IntoPyArray;
use photosite::Invalid;
use photosite::capture::{Capture as LoadedCapture, relative_path};
use photosite::pipeline::{
    self, Destination, DeviceChoice, Event, FilmMemory, LightSource, Monitor, Options, Prepared, Request, TracedLight,
    render_into,
};
use photosite::report::{Report, Timings};
use pyo3::prelude::*;

use crate::array::{Numbers, of_pixels, of_stack};
use crate::capture::Capture;
use crate::error::PYTHON;
use crate::shot::{Shot, report_of, seen_noise, truth};
use crate::work::{How, work};

/// Light that was traced, with the scene that it comes from.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Light(pipeline::Light);

/// Expectation that light of this class is traced, for panics.
const TRACED: &str = "traced light";

fn film_memory(gib: Option<f64>) -> photosite::Result<FilmMemory> {
    gib.map_or_else(|| Ok(FilmMemory::default()), FilmMemory::gib)
}

/// Choice of a device, which is written as for the command's `--device`.
pub(crate) fn device_choice(device: &str) -> photosite::Result<DeviceChoice> {
    let refuse = |words: String| Invalid::new("device", format!("{device:?}: {words}")).in_file(Path::new(PYTHON));
    device.parse().map_err(refuse)
}

/// The capture on a device.
fn on_device(capture: &LoadedCapture, device: &str, monitor: &dyn Monitor) -> photosite::Result<LoadedCapture> {
    device_choice(device)?.settle(LoadedCapture::clone(capture), monitor)
}

/// Devices of this machine, as JSON.
#[pyfunction]
pub(crate) fn devices(py: Python<'_>) -> PyResult<String> {
    work(py, How::default(), |_| Ok(serde_json::to_string(&pipeline::devices()).expect("plain values")))
}

/// Traces the light of the first image of a capture.
#[pyfunction]
pub(crate) fn trace(
    py: Python<'_>,
    capture: &Capture,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
    film_memory_gib: Option<f64>,
    checkpoint: Option<PathBuf>,
    device: &str,
) -> PyResult<Light> {
    let capture = capture.capture();
    work(py, How { threads, progress }, |monitor| {
        let film_memory = film_memory(film_memory_gib)?;
        let prepared = Prepared::new(on_device(capture, device, monitor)?)?;
        prepared.warnings().iter().for_each(|warning| monitor.report(Event::Warning(warning)));
        let light = prepared.trace(Options {
            monitor,
            film_memory,
            checkpoint: checkpoint.as_deref(),
            ..Options::default()
        })?;
        Ok(Light(light))
    })
}

/// Renders a capture into a folder as the command does, and returns its report as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub(crate) fn render_to(
    py: Python<'_>,
    capture: &Capture,
    folder: PathBuf,
    overwrite: bool,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
    film_memory_gib: Option<f64>,
    device: &str,
) -> PyResult<String> {
    let capture = capture.capture();
    let report: Report = work(py, How { threads, progress }, |monitor| {
        let capture = &on_device(capture, device, monitor)?;
        let light = LightSource::Traced;
        let mut place = match Destination::claim(&folder, overwrite, capture, &light, monitor)? {
            Destination::Free(place) => place,
            Destination::Done(rendered) => return Ok(report_of(rendered)),
        };
        let input = capture.source().path();
        let request = Request {
            input,
            named: relative_path(input, place.path()),
            light,
            film_memory: film_memory(film_memory_gib)?,
            monitor,
            is_timed: true,
        };
        let report = report_of(render_into(LoadedCapture::clone(capture), &request, &mut place, Timings::default())?);
        seen_noise(&report).iter().for_each(|words| monitor.report(Event::Warning(words)));
        Ok(report)
    })?;
    Ok(serde_json::to_string(&report).expect("plain values"))
}

impl Light {
    fn traced(&self) -> Arc<TracedLight> {
        self.0.traced().expect(TRACED)
    }
}

#[pymethods]
impl Light {
    /// Columns and rows of the sensor.
    fn resolution(&self) -> [usize; 2] {
        self.0.settings().sensor.resolution
    }

    fn channels(&self) -> Vec<String> {
        self.0.settings().sensor.cfa.channels().to_vec()
    }

    /// Rates of electrons and their variance, e⁻/s and (e⁻/s)²: (rows, columns, channels).
    fn rates<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let rates = &self.traced().rates;
        Ok((of_stack(py, &rates.mean)?, of_stack(py, &rates.variance)?))
    }

    /// Irradiance, (rows, columns, bands), and the central wavelengths of its bands, nm.
    fn irradiance<'py>(&self, py: Python<'py>) -> PyResult<Option<(Bound<'py, PyAny>, Numbers<'py>)>> {
        let Some(bands) = self.traced().irradiance() else { return Ok(None) };
        let wavelengths: Vec<f64> = bands.channels().iter().filter_map(|channel| channel.name.parse().ok()).collect();
        Ok(Some((of_stack(py, &bands)?, wavelengths.into_pyarray(py))))
    }

    /// Samples of each pixel, (rows, columns).
    fn samples<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let [columns, rows] = self.0.settings().sensor.resolution;
        of_pixels(py, [rows, columns, 1], self.traced().samples.clone())
    }

    fn paths(&self) -> u64 {
        self.traced().paths
    }

    fn trace_s(&self) -> f64 {
        self.traced().trace_s
    }

    /// Monte Carlo noise over that of the sensor at the exposure of the capture, where it is known.
    fn noise_ratio(&self) -> Option<f64> {
        self.0.noise_ratio()
    }

    /// Pose and intrinsics as a report has them, as JSON.
    fn camera(&self) -> String {
        serde_json::to_string(&self.0.prepared().expect(TRACED).camera_report()).expect("plain values")
    }

    /// Exposes to the light as often as is said, on a device, with changes to what light leaves open.
    fn expose(
        &self,
        py: Python<'_>,
        changes: Vec<String>,
        frames: u32,
        threads: Option<usize>,
        device: &str,
    ) -> PyResult<Vec<Shot>> {
        work(py, How { threads, progress: None }, |monitor| {
            let card = device_choice(device)?.sensor_card(monitor)?;
            Shot::series(&self.0.with(&changes)?.on_card(card), frames, monitor)
        })
    }

    /// Layers of ground truth by their names, each (rows, columns) or (rows, columns, components).
    fn truth<'py>(&self, py: Python<'py>, layers: Vec<String>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        truth(py, &self.0, &layers)
    }
}
