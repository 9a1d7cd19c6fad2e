//! How cameras and objects move.

use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::Deserialize;

use photosite_calibration::dataset::InterpolationName;

/// Motion of the camera: at constant velocities, from the pose of `[camera]` at the start of the first exposure on; on a
/// turntable; or through poses. capture.json and what is made of it have the pose halfway through the first exposure,
/// pose_time_s after its start.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraMotionTable {
    /// Velocity of the lens along the world's axes, m/s. Left out: 0.
    pub(crate) velocity_m_per_s: Option<[f64; 3]>,
    /// Angular velocity about the camera's own axes (x right, y up, z backward), degrees per second; about y, above 0,
    /// it pans to the left. Left out: 0.
    pub(crate) angular_velocity_deg_per_s: Option<[f64; 3]>,
    /// Turntable in place of velocities: the camera goes around an axis that it stays turned to. Left out, as is its
    /// centre_m: about the point that `[camera]` looks at.
    pub(crate) turntable: Option<TurntableTable>,
    /// Poses at times in place of velocities. Before the first and after the last the camera stands still. `[camera]`
    /// then has no other keys.
    pub(crate) poses: Option<Vec<PoseTable>>,
    /// Interpolation from one pose to the next. Left out: "linear".
    pub(crate) interpolation: Option<InterpolationName>,
}

/// Pose of a camera at a time.
#[derive(Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseTable {
    /// Time from the start of the first exposure, s.
    pub(crate) time_s: f64,
    /// Centre of the lens, m.
    pub(crate) position_m: [f64; 3],
    /// Point on the optical axis, m.
    pub(crate) look_at_m: [f64; 3],
    /// Direction that is up in the image. Left out: [0, 1, 0].
    pub(crate) up: Option<[f64; 3]>,
}

/// Motion of an object: at constant velocities, from its pose at the time 0 of the scene on; on a turntable; or
/// through poses. The first exposure starts at scene.time_s.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectMotionTable {
    /// Velocity of its origin along the world's axes, m/s. Left out: 0.
    pub(crate) velocity_m_per_s: Option<[f64; 3]>,
    /// Angular velocity about its own axes, through its origin, degrees per second. Left out: 0.
    pub(crate) angular_velocity_deg_per_s: Option<[f64; 3]>,
    /// Turntable in place of velocities: the object turns about an axis of the world. Left out, as is its centre_m:
    /// about its own origin.
    pub(crate) turntable: Option<TurntableTable>,
    /// Poses at times in place of velocities. Before the first and after the last the object stands still. Then its own
    /// position_m and rotation are left out.
    pub(crate) poses: Option<Vec<ObjectPoseTable>>,
    /// Interpolation from one pose to the next. Left out: "linear".
    pub(crate) interpolation: Option<InterpolationName>,
}

/// Pose of an object at a time.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectPoseTable {
    /// Time of the scene, s.
    pub(crate) time_s: f64,
    /// Origin of the object, m.
    pub(crate) position_m: [f64; 3],
    /// Rotation about the world's x axis, then y, then z, degrees. Left out, as are the other two: none.
    pub(crate) rotation_deg: Option<[f64; 3]>,
    /// Rotation as a quaternion w, x, y, z, of any length; instead of rotation_deg.
    pub(crate) quaternion_wxyz: Option<[f64; 4]>,
    /// Point that the object's +z axis faces, with its y axis up; instead of rotation_deg.
    pub(crate) look_at_m: Option<[f64; 3]>,
}

/// Rotation about an axis of the world at constant speed.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct TurntableTable {
    /// Point of the axis, m. Left out: the origin of an object, or the point that a camera looks at.
    pub(crate) centre_m: Option<[f64; 3]>,
    /// Direction of the axis, of any length. Left out: [0, 1, 0].
    pub(crate) axis: Option<[f64; 3]>,
    /// Angular velocity, degrees per second, counter-clockwise seen against the axis, which for an axis that points up
    /// is from above.
    pub(crate) speed_deg_per_s: f64,
}
