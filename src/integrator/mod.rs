//! Light transport: how much radiance arrives along a ray ([`path`]), and the loop over the pixels ([`render`]).
//!
//! In: a [`Scene`](crate::scene::Scene), a camera, responses. Out: a [`Film`](crate::film::Film).

pub mod path;
mod render;
mod settings;

pub use render::{RenderJob, Step, render};
pub use settings::RenderSettings;
