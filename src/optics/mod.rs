//! The camera's optics: where on the aperture a path leaves towards the scene, and what its radiance counts on the
//! sensor.
//!
//! In: a [`LensDescription`], the pose, the pixel grid. Out: rays and the weight that turns radiance into irradiance.

mod aperture;
mod camera;
mod description;
mod field_of_view;
mod motion;
mod projection;
mod recording;

pub use camera::{Camera, CameraRay, PixelGrid};
pub use description::{Falloff, Focus, Intrinsics, LensDescription, LensKind};
pub use field_of_view::FieldOfView;
pub use motion::{CameraMotion, TimedPose};
pub use projection::{BrownConrady, Projection, Reach, ReachEnd, Seen};
pub use recording::Recording;
