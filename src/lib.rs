//! photosite renders a glTF or OBJ scene as a camera would record it: spectral radiance is path-traced through a
//! lens, falls on an image sensor as irradiance, becomes electrons, then digital numbers in a raw file, then an RGB
//! picture. Every stage is a physical quantity with a unit and can be written out on its own.
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
//! # What depends on what
//!
//! [`units`], [`math`] → [`spectrum`], [`image`] → [`colour`]; → [`geometry`], [`texture`] → [`bsdf`], [`light`] → [`scene`] →
//! [`optics`], [`film`], [`sampler`] → [`integrator`]. [`sensor`], [`raw`] and [`develop`] see only units, math,
//! spectrum, image and, of lenses, [`projection`]: no scene, no ray. Only [`io`], `cli` and [`raw`] touch files. `tests/architecture.rs` holds
//! these edges. [`calibration`] draws targets and asks a scene what is really there at each pixel. [`validation`]
//! compares pictures and sees units, math, image and raw; [`measure`] takes
//! figures from pictures; [`characterisation`] takes and evaluates
//! images of even light as EMVA 1288 has it and sees sensor and what sensor sees; [`io::mitsuba`] describes a capture to
//! an independent renderer.
//!
//! # Invariants
//!
//! - SI units inside the program, wavelengths in nanometres. Keys in files carry their unit (`focal_length_mm`).
//! - World: metres, right-handed, +Y up; a camera looks along −Z of its node (glTF).
//! - Pixels: continuous coordinates from the top-left corner; pixel (i, j) covers [i, i+1) × [j, j+1).
//! - Directions: `wo` is known, `wi` is sampled, both point away from the surface; a BSDF's `f` has no cosine.
//! - The same input and seed give the same bytes on any number of threads: every pixel is summed by one thread, in
//!   the order of its samples, and random numbers are keyed by what they are for, never drawn from shared state.
//! - A [`scene::Scene`] is immutable once built: flat tables with `u32` handles.
//! - No input file panics the program; what a user can cause is an [`Error`]. No output is half-written.

#![forbid(unsafe_code)]

pub mod io;

pub use photosite_calibration as calibration;
pub use photosite_core::{Error, Invalid, Result};
pub use photosite_core::{colour, error, image, math, projection, references, spectrum, units};
pub use photosite_imaging::{characterisation, develop, measure, raw, sensor, validation};
pub use photosite_transport::{bsdf, film, geometry, integrator, light, optics, sampler, scene, texture};
