//! Optics of the camera: the point of the aperture at which a path leaves towards the scene, and the weight of its
//! radiance on the sensor.
//!
//! In: a [`LensDescription`], the pose, the pixel grid. Out: rays and the weight that turns radiance into irradiance.

mod aperture;
mod camera;
#[cfg(test)]
mod camera_tests;
mod checks;
mod description;
mod element;
mod field_of_view;
mod focusing;
mod lateral_colour;
mod point_spread;
mod prescribed;
#[cfg(test)]
mod prescribed_tests;
#[cfg(test)]
mod prescribed_wave_tests;
mod recording;
mod spread_store;
mod stop;

pub use camera::{
    Arrival, BeyondImageCircle, Camera, CameraRay, CameraSample, Connection, Landing, LandingRay, LensFigures,
    LensRays, LensTable, NODES_ALONG, PackedCamera, PackedTimes, PixelGrid, PrescriptionFigures, TowardsLens,
};
pub use description::{AutofocusMethod, ContrastAutofocus, Falloff, Focus, LensDescription, LensKind, Sharpness};
pub use element::{GroundLens, Power, SupplementaryLens};
pub use field_of_view::FieldOfView;
pub use lateral_colour::LateralColour;
pub use photosite_core::projection::{BrownConrady, Intrinsics, Projection, Reach, ReachEnd, Seen};
pub use point_spread::{Kernel, KernelField, PointSpread};
pub use recording::Recording;
pub use spread_store::{Shelf, ShelfOf, keep_point_spreads};
pub use stop::Stop;
