//! photosite renders a glTF, OBJ, PLY or STL scene as a camera would record it: spectral radiance is path-traced through a
//! lens, falls on an image sensor as irradiance, becomes electrons, then digital numbers in a raw file, then an RGB
//! picture. Every stage is a physical quantity with a unit and can be written out on its own.
//!
//! ```no_run
//! # fn main() -> photosite::Result<()> {
//! let capture = photosite::Capture::load("scenes/cornell-box/capture.toml")?;
//! let shot = photosite::render(&capture, photosite::Options::default())?;
//! shot.raw.save("raw.dng")?;
//! shot.develop(capture.develop())?.save("image.png")?;
//! # Ok(())
//! # }
//! ```
//!
//! `examples/` has five more programs: an own sensor, one noise stage at a time, a scene that no file holds, stored
//! light that is exposed many times, a raw file that becomes a picture.
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
//! [`pipeline`] takes a [`Capture`] through all of them, in memory or into a folder; [`dataset`] does so again and
//! again.
//!
//! # The crates
//!
//! | crate | holds | sees |
//! |---|---|---|
//! | `photosite-simd` | lanes of numbers; the only `unsafe` code | – |
//! | `photosite-core` | [`units`], [`math`], [`spectrum`], [`colour`], [`image`], [`projection`], [`cells`], errors | simd |
//! | `photosite-transport` | [`geometry`] … [`integrator`]: light from its sources to the sensor | simd, core |
//! | `photosite-imaging` | [`raw`], [`sensor`], [`develop`], [`measure`], [`validation`], [`characterisation`], [`synthetic_noise`] | core |
//! | `photosite-scene-io` | glTF, OBJ, PLY, STL, environments, IES | core, transport |
//! | `photosite-calibration` | [`calibration`]: targets, poses, ground truth, camera files | core, transport |
//! | `photosite-placement` | [`placement`]: places of rigid objects, dropped or standing | core |
//! | `photosite` | this crate: the [`capture`] language, the [`pipeline`], [`report`]s, files ([`io`]), and the command | all |
//!
//! Transport and imaging do not know each other. Only this crate, the readers of scenes and those of raw files touch
//! files; only the command prints.
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

pub mod cache;
pub mod capture;
pub mod cli;
pub mod dataset;
pub mod emva1288;
pub mod io;
pub mod lens_figures;
mod locked;
mod picture;
pub mod pipeline;
pub mod report;
pub mod schedulers;
mod schema_links;
pub mod sight;
#[cfg(feature = "view")]
pub mod view;

pub use capture::Capture;
pub use photosite_calibration as calibration;
pub use photosite_core::{Error, Help, Invalid, Remedy, Result, Sandbox};
pub use photosite_core::{cells, colour, error, image, math, memory, projection, references, spectrum, units};
pub use photosite_imaging::{characterisation, develop, measure, raw, sensor, synthetic_noise, validation};
pub use photosite_placement as placement;
pub use photosite_transport::{bsdf, film, geometry, integrator, light, optics, sampler, scene, texture};
pub use picture::{DevelopedFile, Picture};
pub use pipeline::{Options, Shot, render};
