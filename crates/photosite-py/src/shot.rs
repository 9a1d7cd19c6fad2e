//! Shots: exposures of a sensor to light.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use photosite::calibration::truth::TruthLayer;
use photosite::image::{Estimate, Planes};
use photosite::pipeline::{self, Event, Light, Monitor, OutputFolder, Rendered};
use photosite::report::{RenderNoise, Report};
use photosite::sensor::NoiseMap;
use photosite::{DevelopedImage, Invalid};
use pyo3::prelude::*;

use crate::array::{of_planes, of_stack};
use crate::error::{PYTHON, raise};
use crate::raw::{Raw, of_codes};
use crate::work::{How, work};

/// Shot with the light that it is made from, and made from again where more is asked of it.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Shot {
    light: Light,
    raw: Arc<photosite::raw::RawImage>,
    /// Shot without its raw image.
    shot: pipeline::Shot,
}

/// Layers of ground truth by their names.
pub(crate) fn truth<'py>(py: Python<'py>, light: &Light, names: &[String]) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let planes = work(py, How::default(), |monitor| {
        let in_python = |invalid: Invalid| invalid.in_file(Path::new(PYTHON));
        let unknown = || in_python(Invalid::new("truth", "is not known for light that does not come from a scene"));
        let prepared = light.prepared().ok_or_else(unknown)?;
        let layers: Vec<TruthLayer> = names.iter().map(|name| layer(name)).collect::<Result<_, _>>()?;
        let planes = prepared.truth(&layers, monitor)?;
        let [width, height] = [planes.width(), planes.height()];
        let mut channels = planes.into_channels().into_iter();
        let one =
            |layer: &TruthLayer| Planes::new(width, height, channels.by_ref().take(layer.channels().len()).collect());
        let split: Result<Vec<Planes>, Invalid> = layers.iter().map(one).collect();
        split.map_err(in_python)
    })?;
    planes.into_iter().map(|planes| of_planes(py, planes)).collect()
}

/// Names and units of the layers of ground truth.
#[pyfunction]
pub(crate) fn truth_units() -> Vec<(&'static str, &'static str)> {
    TruthLayer::ALL.map(|layer| (layer.name(), layer.unit())).to_vec()
}

/// A layer by its name.
fn layer(name: &str) -> photosite::Result<TruthLayer> {
    TruthLayer::named(name).ok_or_else(|| {
        let known = TruthLayer::ALL.map(TruthLayer::name).join(", ");
        let invalid = Invalid::new("truth", format!("there is no layer {name:?}"));
        invalid.help(format!("the layers are {known}")).in_file(Path::new(PYTHON))
    })
}

/// A noise map by its name.
fn map(name: &str) -> photosite::Result<NoiseMap> {
    NoiseMap::ALL.into_iter().find(|map| map.name() == name).ok_or_else(|| {
        let known = NoiseMap::ALL.map(NoiseMap::name).join(", ");
        let invalid = Invalid::new("noise", format!("there is no map {name:?}"));
        invalid.help(format!("the maps are {known}")).in_file(Path::new(PYTHON))
    })
}

impl Shot {
    /// Takes `frames` frames, one after the other, with warnings about light and exposures.
    pub(crate) fn series(light: &Light, frames: u32, monitor: &dyn Monitor) -> photosite::Result<Vec<Self>> {
        light.warnings().iter().for_each(|warning| monitor.report(Event::Warning(warning)));
        let (mut shots, mut made) = (light.shots(&[]), Vec::new());
        for frame in 0..frames {
            if monitor.is_cancelled() {
                let help = Some("nothing of it is kept".into());
                return Err(photosite::Error::Cancelled { message: "the work was cancelled".to_owned(), help });
            }
            let mut shot = shots.next().ok_or_else(|| light.no_frame(frame))??;
            shot.warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
            let raw = Arc::new(std::mem::take(&mut shot.raw));
            made.push(Self { light: light.clone(), raw, shot });
        }
        Ok(made)
    }

    /// The shot with its raw image.
    fn whole(&self) -> pipeline::Shot {
        let mut shot = self.shot.clone();
        shot.raw = (*self.raw).clone();
        shot
    }
}

#[pymethods]
impl Shot {
    fn raw(&self) -> Raw {
        Raw::new(Arc::clone(&self.raw))
    }

    fn frame(&self) -> u32 {
        self.shot.frame
    }

    fn channels(&self) -> Vec<String> {
        self.shot.electrons.mean.channels().iter().map(|channel| channel.name.clone()).collect()
    }

    /// Exposure time, s, analogue and digital gain, dB, and temperature, °C.
    fn exposure(&self) -> (f64, f64, f64, f64) {
        let exposure = &self.shot.exposure;
        (exposure.time.0, exposure.gain.0, exposure.digital_gain.0, exposure.temperature.0)
    }

    /// Mean electrons, (rows, columns, channels), and their variance from light transport, where it is known.
    fn electrons<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyAny>>)> {
        let Estimate { mean, variance } = &*self.shot.electrons;
        let variance = if variance.channels().is_empty() { None } else { Some(of_stack(py, variance)?) };
        Ok((of_stack(py, mean)?, variance))
    }

    /// Monte Carlo noise over that of the sensor, where it is known.
    fn noise_ratio(&self) -> Option<f64> {
        self.light.noise_ratio()
    }

    /// Warning about Monte Carlo noise that may be seen.
    fn seen_noise(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let report = self.light.report(&self.whole()).map_err(|error| raise(py, error))?;
        Ok(seen_noise(&report))
    }

    /// Develops the raw image as its capture says.
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let settings = self.light.settings().develop;
        let image = work(py, How::default(), |_| Ok(DevelopedImage::develop(&self.raw, settings)?.encoded()))?;
        of_codes(py, image)
    }

    /// The names of all noise maps.
    fn noise_names(&self) -> Vec<&'static str> {
        NoiseMap::ALL.map(NoiseMap::name).to_vec()
    }

    /// A noise map by its name.
    fn noise<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let planes = work(py, How::default(), |_| Ok(self.light.again(&self.shot, &[map(name)?])?.noise_maps.planes))?;
        of_planes(py, planes)
    }

    /// Layers of ground truth by their names.
    fn truth<'py>(&self, py: Python<'py>, layers: Vec<String>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        truth(py, &self.light, &layers)
    }

    /// Report of the shot, as JSON: the contents of capture.json.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        let report = self.light.report(&self.whole()).map_err(|error| raise(py, error))?;
        Ok(serde_json::to_string(&report).expect("plain values"))
    }

    /// Writes into a folder the files that the command writes, and returns the report as JSON.
    fn save(&self, py: Python<'_>, folder: PathBuf, overwrite: bool) -> PyResult<String> {
        let report = work(py, How::default(), |monitor| {
            let mut place = OutputFolder::claim(&folder, overwrite)?;
            self.light.write_shot_into(&self.shot, &mut place, &Quiet(monitor))
        })?;
        Ok(serde_json::to_string(&report).expect("plain values"))
    }
}

/// Warning about Monte Carlo noise that may be seen.
pub(crate) fn seen_noise(report: &Report) -> Option<String> {
    let render = report.traced.render.as_ref()?;
    let noise = RenderNoise::new(render, |samples| format!("samples={samples}"))?;
    noise.is_seen.then_some(noise.words)
}

/// Report of an image, which is all that is rendered here.
pub(crate) fn report_of(rendered: Rendered) -> Report {
    match rendered {
        Rendered::Image { report, .. } => *report,
        Rendered::Part(_) => unreachable!("no part was asked for"),
    }
}

/// Monitor that keeps warnings to itself, which were given when the shot was made.
struct Quiet<'a>(&'a dyn Monitor);

impl Monitor for Quiet<'_> {
    fn report(&self, _: Event<'_>) {}

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}
