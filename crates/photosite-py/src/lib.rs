//! The compiled half of the Python package `photosite`: what passes between Python and the library. It converts, maps
//! errors, frees the interpreter's lock while work is done, and does no work of its own. What users see is Python, in
//! `python/photosite`, and is documented there.

mod array;
mod capture;
mod command;
mod error;
mod light;
mod raw;
mod sensor;
mod shot;
mod work;

use photosite_simd::Heap;
use pyo3::prelude::*;

/// As the program has it: says so where memory ends.
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
    use super::light::{Light, render_to, trace};
    #[pymodule_export]
    use super::raw::{Raw, develop};
    #[pymodule_export]
    use super::sensor::{Sensor, expose_irradiance, expose_planes, expose_stored, illuminant_spectrum};
    #[pymodule_export]
    use super::shot::Shot;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
