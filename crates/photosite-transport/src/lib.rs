//! Light transport: the paths of light from its sources to the sensor's surface.
//!
//! In: the description of a scene ([`scene::description::SceneDescription`]), a lens, the responses of a sensor. Out: a
//! [`film::Film`] with the mean and the variance of each response in each pixel. Electrons, digital numbers and files
//! are left to others: nothing here touches a file or knows of noise.
//!
//! [`geometry`], [`texture`] → [`bsdf`], [`light`] → [`scene`] → [`optics`], [`film`], [`sampler`] → [`integrator`].
//!
//! # Invariants
//!
//! - SI units, wavelengths in nanometres. World: metres, right-handed, +Y up; a camera looks along −Z of its node.
//! - Pixels: continuous coordinates from the top-left corner; pixel (i, j) covers [i, i+1) × [j, j+1).
//! - Directions: `wo` is known, `wi` is sampled, both point away from the surface; a BSDF's `f` has no cosine.
//! - The same input and seed give the same bytes on any number of threads: every pixel is summed by one thread, in
//!   the order of its samples, and random numbers are keyed by what they are for, never drawn from shared state.
//! - A [`scene::Scene`] is immutable once built: flat tables with `u32` handles.

#![forbid(unsafe_code)]

pub mod bsdf;
pub mod film;
pub mod geometry;
pub mod integrator;
pub mod light;
pub mod optics;
pub mod sampler;
pub mod scene;
pub mod texture;
mod tuning;
