//! Light transport: how much radiance arrives along a ray, and the loop over the pixels.

mod settings;

pub use settings::{RenderSettings, SamplerKind};
