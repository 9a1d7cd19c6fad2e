//! The camera's optics: where on the aperture a path leaves towards the scene, and what its radiance counts on the
//! sensor.
//!
//! In: a [`LensDescription`], the pose, the pixel grid. Out: rays and the weight that turns radiance into irradiance.

mod aperture;
mod camera;
mod description;
mod distortion;
mod motion;
mod recording;

pub use camera::{Camera, CameraRay, PixelGrid};
pub use description::{Distortion, Falloff, Focus, Intrinsics, LensDescription, LensKind};
pub use motion::{CameraMotion, TimedPose};
pub use recording::Recording;
