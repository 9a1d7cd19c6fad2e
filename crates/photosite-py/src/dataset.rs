//! Data sets: their frames, made where they are missing, and their files.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use photosite::Sandbox;
use photosite::capture::DatasetFile;
use photosite::dataset::{DataSet, DatasetOutcome, MakeOptions, PartFolder};
use photosite::io::exr::read_exr_file;
use photosite::io::image_file::read_image_file;
use photosite::io::truth::by_layer;
use photosite::pipeline::{Event, FilmMemory, LightSource, Monitor};
use photosite::raw::Pixels;
use pyo3::prelude::*;

use crate::array::{of_pixels, of_planes};
use crate::traced_light::device_choice;
use crate::work::{How, work};

/// A data set file with all that it needs.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Dataset(DataSet);

#[pymethods]
impl Dataset {
    /// Reads a data set file, with changes to the keys of its capture, `key=value`, whose light a device traces.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf, overrides: Vec<String>, device: &str) -> PyResult<Self> {
        let everywhere = Sandbox::default();
        work(py, How::default(), |monitor| {
            let choice = device_choice(device)?;
            DataSet::new(&everywhere, DatasetFile::read(&path)?, &overrides, FilmMemory::default())?
                .on_chosen_device(&choice, monitor)
        })
        .map(Self)
    }

    /// Number of frames.
    fn frame_count(&self) -> u32 {
        self.0.frame_count()
    }

    /// Names of the rig's cameras.
    fn cameras(&self) -> Vec<String> {
        self.0.cameras().map(str::to_owned).collect()
    }

    /// Makes the images of these frames that are not in the folder; returns how many this process has made.
    fn render(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        frames: Vec<u32>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<usize> {
        work(py, How { threads, progress }, |monitor| {
            self.0.check_folder(&folder)?;
            let missing = self.0.missing(frames, &folder);
            if missing.is_empty() {
                return Ok(0);
            }
            let frames = self.0.frames(missing, false, monitor)?;
            self.0.check_first(&frames)?;
            let folder = self.0.claim(&folder)?;
            let made =
                self.0.make(&frames, &folder, monitor, MakeOptions::default(), |_, _| Ok(LightSource::Traced))?;
            made.check(&folder)?;
            Ok(made.images)
        })
    }

    /// Takes a folder for the data set, or refuses it.
    fn claim(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        work(py, How::default(), |_| self.0.claim(&folder).map(drop))
    }

    /// Frames of these that lack an image, or a part of one, in the folder.
    fn missing(&self, py: Python<'_>, folder: PathBuf, frames: Vec<u32>) -> PyResult<Vec<u32>> {
        work(py, How::default(), |_| Ok(self.0.missing(frames, &folder)))
    }

    /// Fingerprint of all that decides what is in its images.
    fn fingerprint(&self) -> &str {
        self.0.fingerprint()
    }

    /// Number of samples of each pixel, the same in all images.
    fn samples(&self, py: Python<'_>) -> PyResult<u32> {
        work(py, How::default(), |_| self.0.samples())
    }

    /// Makes the images of these frames, and goes past those that cannot be made.
    fn make(&self, py: Python<'_>, folder: PathBuf, frames: Vec<u32>, threads: Option<usize>) -> PyResult<Told> {
        told(py, threads, |monitor| {
            let frames = self.0.frames(frames, true, monitor)?;
            let folder = self.0.claim(&folder)?;
            self.0.make(&frames, &folder, monitor, ONE_BY_ONE, |_, _| Ok(LightSource::Traced))
        })
    }

    /// Makes these samples of the images, in a folder for them; `input` is the data set file.
    fn make_part(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        frames: Vec<u32>,
        samples: [u32; 2],
        input: PathBuf,
        threads: Option<usize>,
    ) -> PyResult<Told> {
        let samples = samples[0]..samples[1];
        told(py, threads, |monitor| {
            self.0.check_samples(&samples)?;
            let frames = self.0.frames(frames, true, monitor)?;
            let folder = self.0.claim_part(&folder, &samples, &input)?;
            self.0.make(&frames, &folder, monitor, ONE_BY_ONE, |_, _| Ok(LightSource::Part(samples.clone())))
        })
    }

    /// Makes the images of these frames from the parts that the folders hold.
    fn merge(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        frames: Vec<u32>,
        parts: Vec<PathBuf>,
        threads: Option<usize>,
    ) -> PyResult<Told> {
        told(py, threads, |monitor| {
            let parts = parts.iter().map(|part| PartFolder::read(part)).collect::<photosite::Result<Vec<_>>>()?;
            let frames = self.0.frames(frames, true, monitor)?;
            self.0.merge(&parts, &frames, &folder, monitor, ONE_BY_ONE).map(|(_, made)| made)
        })
    }

    /// Writes the summary of the images in the folder, and counts them; returns why calibration files are left out and
    /// what reports warn of, too.
    fn write_index(&self, py: Python<'_>, folder: PathBuf) -> PyResult<Summary> {
        let index = work(py, How::default(), |_| self.0.write_index(&self.0.open(&folder)?))?;
        Ok((index.present, index.left_out, index.warnings))
    }
}

/// Summary of a folder: the number of images, reasons why calibration files are left out, and warnings of the images'
/// reports.
type Summary = (usize, Vec<String>, Vec<String>);

/// Options of a worker, which goes past frames that cannot be made. One that dies loses no more than the image that it
/// is at. The driver of the run reads the reports of all.
const ONE_BY_ONE: MakeOptions = MakeOptions { keeps_going: true, jobs: Some(1), leaves_warnings: true };

/// Frame that could not be made: its number, the reason, and whether another try may succeed.
type Failure = (u32, String, bool);
/// The frames that could not be made, and warnings.
type Told = (Vec<Failure>, Vec<String>);

/// Does work that goes past frames that cannot be made, and returns the failures and warnings meanwhile.
fn told(
    py: Python<'_>,
    threads: Option<usize>,
    job: impl FnOnce(&dyn Monitor) -> photosite::Result<DatasetOutcome> + Send,
) -> PyResult<Told> {
    work(py, How { threads, progress: None }, |monitor| {
        let listener = Listener { monitor, failures: Mutex::default(), warnings: Mutex::default() };
        job(&listener)?;
        Ok((kept(listener.failures), kept(listener.warnings)))
    })
}

/// Listener that keeps frames that cannot be made, and warnings, for somebody in another process.
struct Listener<'a> {
    monitor: &'a dyn Monitor,
    failures: Mutex<Vec<Failure>>,
    warnings: Mutex<Vec<String>>,
}

impl Monitor for Listener<'_> {
    fn report(&self, event: Event<'_>) {
        if let Event::ImageFails { frame, error, .. } = event {
            let failure = (frame, error.to_string(), error.is_temporary());
            self.failures.lock().unwrap_or_else(PoisonError::into_inner).push(failure);
        } else if let Event::Warning(words) = event {
            self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(words.to_owned());
        } else {
            self.monitor.report(event);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.monitor.is_cancelled()
    }
}

fn kept<T>(list: Mutex<T>) -> T {
    list.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// The planes of an EXR file by their names, those of a layer of ground truth together.
#[pyfunction]
pub(crate) fn read_exr_arrays(py: Python<'_>, path: PathBuf) -> PyResult<BTreeMap<String, Py<PyAny>>> {
    let layers = work(py, How::default(), |monitor| {
        let image = read_exr_file(&path)?;
        image.warnings.iter().for_each(|what| monitor.report(Event::Warning(&format!("{}: {what}", path.display()))));
        Ok(by_layer(image.planes))
    })?;
    layers.into_iter().map(|(name, planes)| Ok((name, of_planes(py, planes)?.unbind()))).collect()
}

/// The codes of a PNG file, as they are.
#[pyfunction]
pub(crate) fn read_codes(py: Python<'_>, path: PathBuf) -> PyResult<Py<PyAny>> {
    let image = work(py, How::default(), |monitor| {
        let image = read_image_file(&path, Pixels::All)?;
        image.said().for_each(|what| monitor.report(Event::Warning(&what)));
        Ok(image)
    })?;
    let channels = image.mean.channels();
    let shape = [image.mean.height(), image.mean.width(), channels.len()];
    let codes = (0..shape[0] * shape[1]).flat_map(|i| channels.iter().map(move |channel| channel.data[i]));
    let array = if image.full_scale.is_some_and(|most| most > 255.0) {
        of_pixels(py, shape, codes.map(|code| code as u16).collect())
    } else {
        of_pixels(py, shape, codes.map(|code| code as u8).collect())
    };
    array.map(Bound::unbind)
}
