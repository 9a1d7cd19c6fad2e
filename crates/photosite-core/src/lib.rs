//! Foundation of all other crates of photosite, independent of rays, sensors and file formats: [`units`], mathematics
//! ([`math`]), spectra ([`spectrum`]), colour ([`colour`]), images in memory ([`image`]), the projections of lenses
//! ([`projection`]), where a sensor's [`cells`] are, and the errors and warnings that users read.
//!
//! SI units throughout, wavelengths in nanometres.

#![forbid(unsafe_code)]

// By which derived code names this crate, within it too.
extern crate self as photosite_core;

pub mod cells;
pub mod cleanup;
pub mod colour;
mod counted;
pub mod error;
pub mod fail_point;
pub mod help;
pub mod image;
pub mod image_grid;
pub mod input;
pub mod json;
pub mod key_path;
pub mod keys;
pub mod locked;
pub mod math;
pub mod memory;
pub mod output;
pub mod projection;
pub mod references;
pub mod rows;
pub mod sandbox;
pub mod schema_range;
pub mod shorten;
pub mod spectrum;
pub mod suggest;
pub mod text;
pub mod toml_text;
pub mod units;
pub mod warnings;

pub use counted::counted;
pub use error::{Error, Invalid, Result};
pub use help::{Help, Remedy};
pub use sandbox::Sandbox;
