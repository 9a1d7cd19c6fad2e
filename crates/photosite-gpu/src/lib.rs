//! Light transport and exposure on graphics cards, by kernels in WGSL through wgpu, on Vulkan, Metal and DirectX: the
//! paths of [`integrator`](photosite_transport::integrator), and the stages of `photosite_sensor::expose`.
//!
//! In: a scene as plain data ([`scene::packed`](photosite_transport::scene::packed)), starts of paths whose rays the
//! camera has made on the processor. Out: what arrives along each. Or in: mean electrons and an exposure as plain data
//! (`photosite_sensor::packed`). Out: digital numbers. Lenses and films stay where they are.
//!
//! | file | holds |
//! |---|---|
//! | `support` | settings that a card does not have, by key |
//! | `adapters` | the cards of this machine |
//! | `buffers`, `params` | its tables and numbers on a card |
//! | `kernels` | the kernels, compiled once for the features that a scene has |
//! | `tracer` | a scene on a card, and batches of paths: generate, extend, shade, shadow, arrive |
//! | `shaders` | the kernels in one text; numbers that Rust and WGSL share are made of Rust's constants |
//! | `expose` | light on a card, and exposures of it: `wgsl/sensor` by `exposure_kernel` and `exposure_shaders` |
//! | `wgsl` | the kernels, a file for each concept, each with the Rust file that it follows in its head |
//!
//! The processor is the reference: random numbers are the same bit for bit, and images differ by rounding and its
//! consequences alone. On one card and driver the same paths bring the same bytes, since each is summed by itself.
//!
//! Without the feature `gpu`, which needs wgpu, this crate only tells which settings cards lack.

#![forbid(unsafe_code)]

pub mod support;

#[cfg(feature = "gpu")]
mod adapters;
#[cfg(feature = "gpu")]
mod buffers;
#[cfg(feature = "gpu")]
mod kernels;
#[cfg(feature = "gpu")]
mod params;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub mod probe;
#[cfg(feature = "gpu")]
pub mod shaders;
#[cfg(feature = "gpu")]
mod tracer;

#[cfg(feature = "gpu")]
mod expose;
#[cfg(feature = "gpu")]
mod exposure_kernel;
#[cfg(feature = "gpu")]
pub mod exposure_shaders;

#[cfg(feature = "gpu")]
pub use expose::HeldLight;

#[cfg(feature = "gpu")]
pub use adapters::{Adapter, Card, adapters, open};
