//! Raw images: their digital numbers, metadata and files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::PyReadonlyArray1;
use photosite::capture::read_develop_settings;
use photosite::develop::{Codes, EncodedImage};
use photosite::io::developable::{Developable, read_developable, read_digital_numbers};
use photosite::io::developed::DevelopedValues;
use photosite::io::formats::{NPY, TIFF, lists};
use photosite::io::raw_file::save_raw;
use photosite::pipeline::Event;
use photosite::raw::{BlackLevel, Cfa, RawImage};
use photosite::{DevelopedFile, DevelopedImage};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{of_pixels, of_planes};
use crate::error::{PYTHON, raise};
use crate::work::{How, work};

/// A raw image.
#[pyclass(frozen, module = "photosite._photosite")]
pub(crate) struct Raw(Arc<RawImage>);

impl Raw {
    pub(crate) fn new(image: impl Into<Arc<RawImage>>) -> Self {
        Self(image.into())
    }

    pub(crate) fn image(&self) -> &Arc<RawImage> {
        &self.0
    }
}

#[pymethods]
impl Raw {
    /// Reads a file of digital numbers.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        work(py, How::default(), |_| read_digital_numbers(&path)).map(Self)
    }

    /// Raw image of these digital numbers with the metadata of `description`.
    #[staticmethod]
    fn of_description(py: Python<'_>, description: &str, numbers: PyReadonlyArray1<'_, u16>) -> PyResult<Self> {
        let known: RawImage =
            serde_json::from_str(description).map_err(|reason| damaged(py, &format!("is damaged: {reason}")))?;
        checked(py, RawImage { data: numbers.as_slice()?.to_vec(), ..known })
    }

    /// Raw image of digital numbers of which these figures alone are known.
    #[staticmethod]
    fn of_numbers(
        py: Python<'_>,
        shape: [usize; 2],
        numbers: PyReadonlyArray1<'_, u16>,
        cfa: &str,
        black_level_dn: f32,
        white_level_dn: u16,
    ) -> PyResult<Self> {
        let [height, width] = shape;
        let cfa = Cfa::parse(cfa).map_err(|invalid| raise(py, invalid.in_file(Path::new(PYTHON))))?;
        let bare = RawImage::bare(width, height, numbers.as_slice()?.to_vec(), cfa, white_level_dn);
        checked(py, RawImage { black_level_dn: BlackLevel::uniform(black_level_dn), ..bare })
    }

    /// Raw image of other digital numbers with the same metadata.
    fn with_numbers(&self, py: Python<'_>, numbers: PyReadonlyArray1<'_, u16>) -> PyResult<Self> {
        checked(py, self.0.with_data(numbers.as_slice()?.to_vec()))
    }

    /// Interface by which NumPy makes an array without a copy, which cannot be written to and keeps this object alive.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let RawImage { width, height, data, cfa, .. } = &*self.0;
        let interface = PyDict::new(py);
        match cfa.samples_per_pixel() {
            1 => interface.set_item("shape", (*height, *width))?,
            samples => interface.set_item("shape", (*height, *width, samples))?,
        }
        interface.set_item("typestr", if cfg!(target_endian = "big") { ">u2" } else { "<u2" })?;
        interface.set_item("data", (data.as_ptr() as usize, true))?;
        interface.set_item("version", 3)?;
        Ok(interface)
    }

    /// Metadata of the raw image, as JSON.
    fn description(&self) -> String {
        serde_json::to_string(&*self.0).expect("plain values")
    }

    /// The text that sensor files have for its colour filter array.
    fn cfa(&self) -> String {
        self.0.cfa.to_string()
    }

    /// Text of the colour filter array of the pixels that see light.
    fn active_cfa(&self) -> String {
        self.0.active_cfa().to_string()
    }

    /// Black levels of all digital numbers, row by row, DN.
    fn black_levels_dn<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let RawImage { height, width, cfa, black_level_dn, .. } = &*self.0;
        let samples = cfa.samples_per_pixel();
        let levels = (0..*height).flat_map(|y| (0..width * samples).map(move |x| black_level_dn.at(x, y)));
        of_pixels(py, [*height, *width, samples], levels.collect())
    }

    /// Pixel aspect ratio, width over height.
    fn pixel_aspect(&self) -> f64 {
        self.0.metadata.pixel_aspect()
    }

    /// Correlated colour temperatures of the lights of the calibrations, K.
    fn light_temperatures_k(&self) -> Vec<f64> {
        self.0.metadata.calibrations.iter().map(|calibration| calibration.light.temperature_k()).collect()
    }

    /// Writes the raw image in the format that the extension asks for, in the place of an older file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        work(py, How::default(), |_| save_raw(&self.0, &path))
    }
}

/// A raw image whose parts belong together.
fn checked(py: Python<'_>, image: RawImage) -> PyResult<Raw> {
    image.validate().map_err(|invalid| raise(py, invalid.in_file(Path::new(PYTHON))))?;
    Ok(Raw::new(image))
}

fn damaged(py: Python<'_>, message: &str) -> PyErr {
    raise(py, photosite::Invalid::new("description", message).in_file(Path::new(PYTHON)))
}

/// Endings of raw files, those of files that state most first.
#[pyfunction]
pub(crate) fn raw_endings() -> Vec<&'static str> {
    lists::raw_endings()
}

/// Develops a raw image, or a file, by `develop.key=value`, to codes or floats.
#[pyfunction]
pub(crate) fn develop(
    py: Python<'_>,
    raw: Option<PyRef<'_, Raw>>,
    path: Option<PathBuf>,
    settings: Vec<String>,
    linear: bool,
) -> PyResult<Py<PyAny>> {
    let image = raw.map(|raw| raw.image().clone());
    let numbers = work(py, How::default(), |monitor| {
        let source = read_develop_settings(None, &settings)?;
        // TIFF holds codes where they are for viewers, and floats of all else.
        let format = if linear { &NPY } else { &TIFF };
        format.check(&source.0).map_err(|invalid| source.1.error(invalid.within("develop")))?;
        let path = path.as_deref().unwrap_or(Path::new(PYTHON));
        let file = image.map_or_else(|| read_developable(path), |image| Ok(Developable::Raw(image)))?;
        let output = (format, Path::new("the array"));
        let DevelopedFile { image, assumed, warnings } = DevelopedImage::develop_file(file, path, &source, output)?;
        assumed.iter().chain(&warnings).for_each(|words| monitor.report(Event::Warning(words)));
        Ok(image.into_numbers(format))
    })?;
    let array = match numbers {
        DevelopedValues::Codes(image) => of_codes(py, image),
        DevelopedValues::Floats(planes, _) => of_planes(py, planes),
    };
    array.map(Bound::unbind)
}

/// Codes of a developed image as an array.
pub(crate) fn of_codes(py: Python<'_>, image: EncodedImage) -> PyResult<Bound<'_, PyAny>> {
    let shape = [image.height, image.width, image.components];
    match image.codes {
        Codes::U8(codes) => of_pixels(py, shape, codes),
        Codes::U16(codes) => of_pixels(py, shape, codes),
    }
}
