//! The compiled half of the Python package `photosite`: what passes between Python and the library. It converts, maps
//! errors, frees the interpreter's lock while work is done, and does no work of its own. What users see is Python, in
//! `python/photosite`, and is documented there.

mod array;
mod capture;
mod command;
mod compare;
mod dataset;
mod emva1288;
mod error;
mod raw;
mod sensor;
mod shot;
mod target;
mod traced_light;
mod training;
mod work;

use photosite_simd::Heap;
use pyo3::prelude::*;

/// Allocator, the same as that of the program: it says so where memory ends.
#[global_allocator]
static HEAP: Heap = Heap;

#[pymodule]
mod _photosite {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::array::write_rgb;
    #[pymodule_export]
    use super::capture::Capture;
    #[pymodule_export]
    use super::command::cli;
    #[pymodule_export]
    use super::compare::{ComparedPicture, compare, difference_picture};
    #[pymodule_export]
    use super::dataset::{Dataset, read_codes, read_exr_arrays};
    #[pymodule_export]
    use super::emva1288::{FittedCamera, evaluate_image_sets, fit_camera, take_image_sets};
    #[pymodule_export]
    use super::raw::{Raw, develop, raw_endings};
    #[pymodule_export]
    use super::sensor::{Sensor, expose_irradiance, expose_planes, expose_stored, illuminant_spectrum};
    #[pymodule_export]
    use super::shot::{Shot, truth_units};
    #[pymodule_export]
    use super::target::{Target, project, unproject};
    #[pymodule_export]
    use super::traced_light::{Light, devices, render_to, trace};
    #[pymodule_export]
    use super::training::shots;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        photosite::cache::keep_on_disk();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
