//! Data sets: one capture taken again and again, by one camera or a rig of them, from other poses and under other
//! conditions.
//!
//! In: a [`DatasetDescription`], the cameras of the rig as their captures make them, the points that must stay in the
//! image. Out: for each frame and camera the changes to the capture, as overrides. Each frame is a function of
//! the description and its number alone, so that any of them can be made by anyone, in any order.

mod description;
mod distribution;
mod draws;
mod origin;
mod placement;
mod plan;
mod poses;
mod rig;
mod toml_value;
mod variation;

pub use description::{
    DatasetDescription, GridPoses, HsvDescription, InterpolationName, PoseDescription, PosesDescription, RandomPoses,
    RigCameraDescription, RotationDescription, SamplingDescription, SphereDescription, TimedPoseDescription,
    TrajectoryPoses, VariationDescription,
};
pub use placement::{
    BinDescription, CountDescription, PlaceDescription, PlaceMethod, PlaceRotation, RegionDescription,
};
pub use plan::{CALIBRATION_FOLDER, Plan};
pub use poses::Subject;
pub use rig::{RigCamera, RigPlace};
pub use toml_value::toml;
pub use variation::Found;
