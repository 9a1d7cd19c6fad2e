//! The camera's optics: where on the aperture a path leaves towards the scene, and what its radiance counts on the
//! sensor.
//!
//! In: a [`LensDescription`], the pose, the pixel grid. Out: rays and the weight that turns radiance into irradiance.

pub mod description;

pub use description::{Distortion, Falloff, Focus, Intrinsics, LensDescription, LensKind};
