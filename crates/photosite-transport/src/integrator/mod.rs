//! Light transport: how much radiance arrives along a ray ([`radiance`]), and the loop over the pixels ([`render`]),
//! which may give each pixel the samples that it needs ([`pilot`]). Paths go from the camera, in waves, and those of
//! neighbouring pixels may share what they find; others start at lights for the sake of caustics.
//!
//! In: a [`Scene`](crate::scene::Scene), a camera, responses. Out: a [`Film`](crate::film::Film).

mod light_paths;
mod mis_ratio;
mod path;
pub mod pilot;
mod render;
mod reuse;
mod settings;
mod wavefront;
mod wavelengths;

pub use path::PathLimits;
pub use pilot::{Pilot, render_with_pilot};
pub use render::{Listener, RenderJob, Step, render, render_on};
pub use settings::RenderSettings;
pub use wavefront::radiance;
pub use wavelengths::{FilterTile, WavelengthChoice};
