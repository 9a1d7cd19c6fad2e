//! Exposures: what a sensor has made of light.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use photosite::calibration::truth::TruthLayer;
use photosite::capture::relative_path;
use photosite::image::{Estimate, Planes};
use photosite::pipeline::{
    self, Carried, Event, ExposedRender, FilmMemory, LightSource, Monitor, OutputFolder, Prepared, Rendered, Request,
};
use photosite::report::{RenderNoise, Report};
use photosite::sensor::NoiseMap;
use photosite::{Invalid, Picture};
use pyo3::prelude::*;

use crate::array::{of_planes, of_stack};
use crate::error::{PYTHON, raise};
use crate::raw::{Raw, of_codes};
use crate::work::{How, work};

/// What shots are made from, and made from again where more is asked of them.
#[derive(Clone)]
pub(crate) enum Source {
    /// Light of a scene.
    Traced { prepared: Arc<Prepared>, light: Arc<pipeline::Light> },
    /// Light that somebody else has computed.
    Stored(Arc<ExposedRender>),
}

/// One exposure.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Shot {
    source: Source,
    frame: u32,
    /// State after the frame before.
    before: Carried,
    raw: Arc<photosite::raw::RawImage>,
    shot: pipeline::Shot,
}

impl Source {
    fn expose(&self, frame: u32, before: &Carried, maps: &[NoiseMap]) -> photosite::Result<pipeline::Shot> {
        match self {
            Self::Traced { prepared, light } => prepared.expose_with_maps(light, frame, before, maps),
            Self::Stored(render) => render.read_out(frame, before, maps),
        }
    }

    /// Layers of ground truth by their names.
    pub(crate) fn truth<'py>(&self, py: Python<'py>, layers: &[String]) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let planes = work(py, How::default(), |monitor| match self {
            Self::Traced { prepared, .. } => {
                let layers: Vec<TruthLayer> = layers.iter().map(|name| layer(name)).collect::<Result<_, _>>()?;
                let planes = prepared.truth(&layers, monitor)?;
                let [width, height] = [planes.width(), planes.height()];
                let mut channels = planes.into_channels().into_iter();
                let one = |layer: &TruthLayer| {
                    Planes::new(width, height, channels.by_ref().take(layer.channels().len()).collect())
                };
                let split: Result<Vec<Planes>, Invalid> = layers.iter().map(one).collect();
                split.map_err(|invalid| invalid.in_file(Path::new(PYTHON)))
            }
            Self::Stored(_) => {
                let invalid = Invalid::new("truth", "is not known for light that does not come from a scene");
                Err(invalid.in_file(Path::new(PYTHON)))
            }
        })?;
        planes.into_iter().map(|planes| of_planes(py, planes)).collect()
    }
}

/// A layer by its name.
fn layer(name: &str) -> photosite::Result<TruthLayer> {
    TruthLayer::ALL.into_iter().find(|layer| layer.name() == name).ok_or_else(|| {
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
    /// So many frames, one after the other, with image lag and gain control from one to the next.
    pub(crate) fn series(source: Source, frames: u32, monitor: &dyn Monitor) -> photosite::Result<Vec<Self>> {
        let mut before = Carried::default();
        let mut shots = Vec::new();
        for frame in 0..frames {
            if monitor.is_cancelled() {
                let help = Some("nothing of it is kept".into());
                return Err(photosite::Error::Cancelled { message: "the work was cancelled".to_owned(), help });
            }
            let mut shot = source.expose(frame, &before, &[])?;
            shot.warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
            let carried = std::mem::take(&mut shot.carried);
            let raw = Arc::new(std::mem::take(&mut shot.raw));
            shots.push(Self {
                source: source.clone(),
                frame,
                before: std::mem::replace(&mut before, carried),
                raw,
                shot,
            });
        }
        Ok(shots)
    }

    /// The shot with its raw image.
    fn whole(&self) -> pipeline::Shot {
        pipeline::Shot { raw: (*self.raw).clone(), ..self.shot.clone() }
    }
}

#[pymethods]
impl Shot {
    fn raw(&self) -> Raw {
        Raw::new(Arc::clone(&self.raw))
    }

    fn frame(&self) -> u32 {
        self.frame
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
        match &self.source {
            Source::Traced { prepared, light } => prepared.noise_ratio(light),
            Source::Stored(_) => None,
        }
    }

    /// What is said of Monte Carlo noise that may be seen.
    fn seen_noise(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let Source::Traced { prepared, light } = &self.source else { return Ok(None) };
        let report = prepared.report(light, &self.whole(), self.frame).map_err(|error| raise(py, error))?;
        Ok(seen_noise(&report))
    }

    /// Develops the raw image as its capture says.
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let picture = work(py, How::default(), |_| {
            let settings = match &self.source {
                Source::Traced { prepared, .. } => prepared.capture().develop(),
                Source::Stored(render) => render.develop_settings(),
            };
            Ok(Picture::develop(&self.raw, settings)?.encoded())
        })?;
        of_codes(py, picture)
    }

    /// The names of all noise maps.
    fn noise_names(&self) -> Vec<&'static str> {
        NoiseMap::ALL.map(NoiseMap::name).to_vec()
    }

    /// A noise map by its name.
    fn noise<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let planes = work(py, How::default(), |_| {
            let shot = self.source.expose(self.frame, &self.before, &[map(name)?])?;
            Ok(shot.noise_maps.planes)
        })?;
        of_planes(py, planes)
    }

    /// Layers of ground truth by their names.
    fn truth<'py>(&self, py: Python<'py>, layers: Vec<String>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        self.source.truth(py, &layers)
    }

    /// What capture.json says, as JSON.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        let report: Report = match &self.source {
            Source::Traced { prepared, light } => prepared.report(light, &self.whole(), self.frame),
            Source::Stored(render) => render.report(&self.whole(), self.frame),
        }
        .map_err(|error| raise(py, error))?;
        Ok(serde_json::to_string(&report).expect("plain values"))
    }

    /// Writes into a folder what the command writes, and returns the report as JSON.
    fn save(&self, py: Python<'_>, folder: PathBuf, overwrite: bool) -> PyResult<String> {
        let report = work(py, How::default(), |monitor| {
            let mut place = OutputFolder::claim(&folder, overwrite)?;
            match &self.source {
                Source::Traced { prepared, light } => {
                    let input = prepared.capture().source().path();
                    let request = Request {
                        input,
                        named: relative_path(input, place.path()),
                        light: LightSource::Given { light, frame: self.frame },
                        film_memory: FilmMemory::default(),
                        monitor: &Quiet(monitor),
                        is_timed: true,
                    };
                    prepared.expose_into(&request, &mut place).map(report_of)
                }
                Source::Stored(render) => {
                    ExposedRender::clone(render).write_frame_into(self.frame, &mut place, &Quiet(monitor))
                }
            }
        })?;
        Ok(serde_json::to_string(&report).expect("plain values"))
    }
}

/// What is said of Monte Carlo noise that may be seen.
pub(crate) fn seen_noise(report: &Report) -> Option<String> {
    let render = report.traced.render.as_ref()?;
    let noise = RenderNoise::new(render, |samples| format!("samples={samples}"))?;
    noise.is_seen.then_some(noise.words)
}

/// The report of a picture, which is all that is rendered here.
pub(crate) fn report_of(rendered: Rendered) -> Report {
    match rendered {
        Rendered::Picture { report, .. } => *report,
        Rendered::Part(_) => unreachable!("no part was asked for"),
    }
}

/// Keeps warnings to itself, which were given when the shot was made.
struct Quiet<'a>(&'a dyn Monitor);

impl Monitor for Quiet<'_> {
    fn report(&self, _: Event<'_>) {}

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}
