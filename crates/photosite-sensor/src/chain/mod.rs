//! The chain of stages of one exposure, and the record of what each has changed.

mod expose;
mod noise_maps;
pub mod packed;
mod recorded;

pub use expose::{ExposedFrame, expose, expose_after, expose_with_maps};
pub use noise_maps::NoiseMaps;
#[cfg(test)]
pub(super) mod tests;
