//! photosite renders a glTF, OBJ, PLY or STL scene as a camera would record it: spectral radiance is path-traced through a
//! lens, falls on an image sensor as irradiance, becomes electrons, then digital numbers in a raw file, then an RGB
//! image. Every stage is a physical quantity with a unit and can be written out on its own.
//!
//! ```no_run
//! # fn main() -> photosite::Result<()> {
//! let capture = photosite::Capture::load("scenes/cornell-box/capture.toml")?;
//! let shot = photosite::render(&capture, photosite::Options::default())?;
//! photosite::save_raw(&shot.raw, "raw.dng")?;
//! shot.develop(capture.develop())?.save("image.png")?;
//! # Ok(())
//! # }
//! ```
//!
//! `examples/` has five more programs: an own sensor, one noise stage at a time, a scene that no file holds, stored
//! light that is exposed many times, a raw file that becomes an image.
//!
//! # The chain
//!
//! | stage | quantity | unit | modules |
//! |---|---|---|---|
//! | light transport | spectral radiance L(x, ω, λ) | W·m⁻²·sr⁻¹·nm⁻¹ | [`scene`], [`geometry`], [`bsdf`], [`light`], [`texture`], [`integrator`] |
//! | optics | spectral irradiance E(x, λ) | W·m⁻²·nm⁻¹ | [`optics`], [`film`] |
//! | exposure | mean photo-electrons | e⁻ | [`film`], [`image`] |
//! | sensor | charge, voltage, digital number | e⁻, V, DN | [`sensor`], [`raw`] |
//! | development | linear and display-referred RGB | – | [`develop`] |
//!
//! [`pipeline`] takes a [`Capture`] through all of them, in memory or into a folder; a data set does so again and again.
//!
//! # The crates
//!
//! | crate | holds |
//! |---|---|
//! | `photosite-core` | [`units`], [`math`], [`spectrum`], [`colour`], [`image`], [`projection`], [`cells`], errors |
//! | `photosite-transport`, `photosite-lens` | [`geometry`] … [`integrator`]: light from its sources to the sensor |
//! | `photosite-gpu` | the same light transport and exposures on graphics cards, for the program (feature `gpu`) |
//! | `photosite-raw`, `-sensor`, `-develop`, `-measure` | [`raw`], [`sensor`], [`develop`], [`measure`], [`validation`], [`characterisation`], [`synthetic_noise`] |
//! | `photosite-scene-io`, `-files`, `-mitsuba` | [`io`]: scenes and images of files |
//! | `photosite-calibration` | [`calibration`]: targets, poses, ground truth, camera files |
//! | `photosite-capture` | the [`capture`] language, its builders ([`keys`]) and [`report`]s |
//! | `photosite-pipeline` | the [`pipeline`] |
//! | `photosite-dataset`, `-placement` | data sets, image sets of a sensor, places of rigid objects (feature `dataset`) |
//! | `photosite-cli`, `-view` | the program, which no library needs (features `command`, `view`) |
//!
//! Light transport and sensors do not know each other. `CONTRIBUTING.md` says what each crate may see.
//!
//! # Invariants
//!
//! - SI units inside the program, wavelengths in nanometres. Keys in files carry their unit (`focal_length_mm`).
//! - World: metres, right-handed, +Y up; a camera looks along −Z of its node (glTF).
//! - Pixels: continuous coordinates from the top-left corner; pixel (i, j) covers [i, i+1) × [j, j+1), unless they are
//!   [`cells::CellShape::Hexagonal`].
//! - Directions: `wo` is known, `wi` is sampled, both point away from the surface; a BSDF's `f` has no cosine.
//! - The same input and seed give the same bytes on any number of threads: every pixel is summed by one thread, in
//!   the order of its samples, and random numbers are keyed by what they are for, never drawn from shared state.
//! - A [`scene::Scene`] is immutable once built: flat tables with `u32` handles.
//! - No input file panics the program; what a user can cause is an [`Error`]. No output is half-written.

#![forbid(unsafe_code)]

pub use photosite_calibration as calibration;
pub use photosite_capture::{self as capture, Capture, keys, report};
pub use photosite_core::{Error, Help, Invalid, Remedy, Result, Sandbox};
pub use photosite_core::{cells, colour, error, image, math, memory, projection, references, spectrum, units};
#[cfg(feature = "dataset")]
pub use photosite_dataset::{self as dataset, emva1288};
pub use photosite_develop as develop;
pub use photosite_files::raw_file::{read_raw, save_raw};
pub use photosite_measure::{characterisation, measures as measure, synthetic_noise, validation};
pub use photosite_pipeline::{
    self as pipeline, DevelopedFile, DevelopedImage, Options, Shot, cache, camera_projection, render,
};
#[cfg(feature = "dataset")]
pub use photosite_placement as placement;
pub use photosite_raw as raw;
pub use photosite_sensor as sensor;
pub use photosite_transport::{bsdf, film, geometry, integrator, light, optics, sampler, scene, texture};

/// Files: images, raw images, irradiance, truth, scenes, and the export to Mitsuba.
pub mod io {
    pub use photosite_core::{cleanup, output};
    pub use photosite_files::*;
    pub use photosite_mitsuba as mitsuba;
    pub use photosite_scene_io::{ChangedMeshes, MeshChange, MissingNormals, complete, gltf, obj, ply, stl};
}
