//! Light transport, exposure and development on graphics cards: the paths of
//! [`integrator`](photosite_transport::integrator), the stages of `photosite_sensor::expose` and the steps of
//! `photosite_develop::develop`, by kernels in WGSL through wgpu, on Vulkan, Metal and DirectX.
//!
//! In: a scene as plain data ([`scene::packed`](photosite_transport::scene::packed)), and either the film with its
//! camera ([`PackedFilm`](photosite_transport::integrator::PackedFilm)), or starts of paths, of cameras that cards do
//! not have. Out: sums of the samples of pixels, or what arrives along each path.
//!
//! Exposures take light and sensor as plain data (`photosite_sensor::packed`) to the digital numbers of a raw image
//! (`Card::expose`); development takes those (`photosite_develop::packed`) to the codes of an image (`Card::develop`).
//!
//! | file | holds |
//! |---|---|
//! | `support` | settings that a card does not have, by key |
//! | `adapters` | the cards of this machine |
//! | `shared_cards` | the cards that this process has open |
//! | `buffers`, `params`, `uniform` | its tables and numbers on a card |
//! | `kernels` | the kernels, compiled once for the features that a scene has |
//! | `tracer` | a scene on a card, and batches of paths: generate, extend, shade, shadow, arrive |
//! | `film`, `pixels` | a film on a card, and samples of its pixels, whose paths start and end there |
//! | `device` | a card as a device of renders, and paths whose starts the processor has made |
//! | `develop` | development of raw images, a file for each concept; `wgsl/develop` has its kernels |
//! | `shaders` | the kernels in one text; numbers that Rust and WGSL share are made of Rust's constants |
//! | `expose` | light on a card, and exposures of it; `wgsl/sensor` has the kernel |
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
pub mod develop;
#[cfg(feature = "gpu")]
mod device;
#[cfg(feature = "gpu")]
pub mod expose;
#[cfg(feature = "gpu")]
mod film;
#[cfg(feature = "gpu")]
mod kernels;
#[cfg(feature = "gpu")]
mod params;
#[cfg(feature = "gpu")]
mod pixels;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub mod probe;
#[cfg(feature = "gpu")]
pub mod shaders;
#[cfg(feature = "gpu")]
mod shared_cards;
#[cfg(feature = "gpu")]
mod tracer;
#[cfg(feature = "gpu")]
mod uniform;

#[cfg(feature = "gpu")]
pub use adapters::{Adapter, Card, adapters, first, open};
#[cfg(feature = "gpu")]
pub use expose::HeldLight;
#[cfg(feature = "gpu")]
pub use shared_cards::shared;
