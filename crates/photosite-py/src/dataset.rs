//! Data sets: their frames, made where they are missing, and their files.

use std::collections::BTreeMap;
use std::path::PathBuf;

use photosite::Sandbox;
use photosite::dataset::{DataSet, MakeOptions};
use photosite::io::exr::read_exr_file;
use photosite::io::picture_file::read_picture_file;
use photosite::io::truth::by_layer;
use photosite::pipeline::{FilmMemory, LightSource};
use photosite::raw::Pixels;
use pyo3::prelude::*;

use crate::array::{of_pixels, of_planes};
use crate::work::{How, work};

/// A data set file with all that it needs.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Dataset(DataSet);

#[pymethods]
impl Dataset {
    /// Reads a data set file, with changes to the keys of its capture, `key=value`.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        let everywhere = Sandbox::default();
        work(py, How::default(), |_| DataSet::read(&everywhere, &path, &overrides, FilmMemory::default())).map(Self)
    }

    /// How many frames there are.
    fn frame_count(&self) -> u32 {
        self.0.frame_count()
    }

    /// The names of its cameras.
    fn cameras(&self) -> Vec<String> {
        self.0.cameras().map(str::to_owned).collect()
    }

    /// Makes the pictures of these frames that are not in the folder; how many, by this process.
    fn render(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        frames: Vec<u32>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<usize> {
        work(py, How { threads, progress }, |monitor| {
            let frames = self.0.frames(frames, false, monitor)?;
            self.0.check_first(&frames)?;
            let folder = self.0.claim(&folder)?;
            let made =
                self.0.make(&frames, &folder, monitor, MakeOptions::default(), |_, _| Ok(LightSource::Traced))?;
            made.check(&folder)?;
            Ok(made.pictures)
        })
    }

    /// Writes the summary of the pictures in the folder, and counts them; with why calibration files are left out.
    fn write_index(&self, py: Python<'_>, folder: PathBuf) -> PyResult<(usize, Vec<String>)> {
        let index = work(py, How::default(), |_| self.0.write_index(&self.0.open(&folder)?))?;
        Ok((index.present, index.left_out))
    }
}

/// The planes of an EXR file by their names, those of a layer of ground truth together.
#[pyfunction]
pub(crate) fn read_exr_arrays(py: Python<'_>, path: PathBuf) -> PyResult<BTreeMap<String, Py<PyAny>>> {
    let layers = work(py, How::default(), |_| Ok(by_layer(read_exr_file(&path)?.planes)))?;
    layers.into_iter().map(|(name, planes)| Ok((name, of_planes(py, planes)?.unbind()))).collect()
}

/// The codes of a PNG file, as they are.
#[pyfunction]
pub(crate) fn read_codes(py: Python<'_>, path: PathBuf) -> PyResult<Py<PyAny>> {
    let picture = work(py, How::default(), |_| read_picture_file(&path, Pixels::All))?;
    let channels = picture.mean.channels();
    let shape = [picture.mean.height(), picture.mean.width(), channels.len()];
    let codes = (0..shape[0] * shape[1]).flat_map(|i| channels.iter().map(move |channel| channel.data[i]));
    let array = if picture.full_scale.is_some_and(|most| most > 255.0) {
        of_pixels(py, shape, codes.map(|code| code as u16).collect())
    } else {
        of_pixels(py, shape, codes.map(|code| code as u8).collect())
    };
    array.map(Bound::unbind)
}
