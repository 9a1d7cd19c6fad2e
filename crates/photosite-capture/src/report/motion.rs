//! Report of a camera or a scene that moves.

use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_calibration::dataset::InterpolationName;
use photosite_transport::geometry::{TimedPose, Trajectory};
use photosite_transport::optics::Recording;

/// Motion during exposure. Row y of frame k sees light from t = k·interval + (|y + ½ − first row| − ½)·row time on, for
/// the exposure time.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct MotionReport {
    /// Path of the camera.
    #[serde(flatten)]
    pub path: PathReport,
    /// Exposure time, s.
    pub exposure_s: f64,
    /// Time from the start of one row to that of the next, s.
    pub row_time_s: f64,
    /// Row that is exposed first.
    pub first_row: f64,
    /// Time from the start of one image to that of the next, s.
    pub frame_interval_s: f64,
}

/// Pose at the time t.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum PathReport {
    /// Steady motion: position + velocity·(t − pose_time_s), and turned about the camera's own glTF axes.
    Steady {
        /// Velocity in the world, m/s.
        velocity_m_per_s: [f64; 3],
        /// Turn about the camera's own axes, °/s.
        angular_velocity_deg_per_s: [f64; 3],
    },
    /// Turntable: the pose at pose_time_s, turned about an axis of the world by speed·(t − pose_time_s).
    Turntable {
        /// Axis and speed.
        turntable: TurntableReport,
    },
    /// Poses, between which position is linear in t and rotation takes the shortest way, or a spline.
    Poses {
        /// Poses in the order of their times.
        poses: Vec<PoseReport>,
        /// Interpolation from one pose to the next; "linear" where nothing is said.
        #[serde(default, skip_serializing_if = "is_linear")]
        interpolation: InterpolationName,
    },
    /// Camera that stands still while the scene moves. Must be the last variant, as it has no keys that the others
    /// lack.
    Still {},
}

/// Rotation about an axis of the world.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct TurntableReport {
    /// Point of the axis, m.
    pub centre_m: [f64; 3],
    /// Direction of the axis, of unit length.
    pub axis: [f64; 3],
    /// Angular speed, counter-clockwise seen against the axis, °/s.
    pub speed_deg_per_s: f64,
}

/// Pose of the camera at a time.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct PoseReport {
    /// Time from the start of the first image, s.
    pub time_s: f64,
    /// Position in the world, m.
    pub position_m: [f64; 3],
    /// Rotation camera (glTF axes) → world, as a quaternion x, y, z, w.
    pub rotation_xyzw: [f64; 4],
}

impl PoseReport {
    fn new(pose: &TimedPose) -> Self {
        Self { time_s: pose.time_s, position_m: pose.position_m.to_array(), rotation_xyzw: pose.rotation.to_array() }
    }
}

fn is_linear(interpolation: &InterpolationName) -> bool {
    *interpolation == InterpolationName::Linear
}

impl MotionReport {
    pub(super) fn new(recording: &Recording) -> Self {
        let path = match &recording.motion {
            None => PathReport::Still {},
            Some(Trajectory::Steady { velocity_m_per_s, angular_velocity_rad_per_s }) => PathReport::Steady {
                velocity_m_per_s: velocity_m_per_s.to_array(),
                angular_velocity_deg_per_s: angular_velocity_rad_per_s.to_array().map(f64::to_degrees),
            },
            Some(Trajectory::Turntable { centre_m, axis, speed_rad_per_s }) => {
                let [centre_m, axis] = [centre_m, axis].map(DVec3::to_array);
                let turntable = TurntableReport { centre_m, axis, speed_deg_per_s: speed_rad_per_s.to_degrees() };
                PathReport::Turntable { turntable }
            }
            Some(Trajectory::Poses(poses)) => PathReport::Poses {
                poses: poses.iter().map(PoseReport::new).collect(),
                interpolation: InterpolationName::Linear,
            },
            Some(Trajectory::Spline(spline)) => PathReport::Poses {
                poses: spline.poses().map(PoseReport::new).collect(),
                interpolation: InterpolationName::Spline,
            },
        };
        let Recording { exposure_s, row_time_s, first_row, frame_interval_s, .. } = *recording;
        Self { path, exposure_s, row_time_s, first_row, frame_interval_s }
    }

    /// Recording of images of `rows` rows.
    pub fn recording(&self, rows: u32) -> Recording {
        let pose = |pose: &PoseReport| TimedPose {
            time_s: pose.time_s,
            position_m: DVec3::from_array(pose.position_m),
            rotation: DQuat::from_array(pose.rotation_xyzw),
        };
        let motion = match &self.path {
            PathReport::Steady { velocity_m_per_s, angular_velocity_deg_per_s } => Some(Trajectory::Steady {
                velocity_m_per_s: DVec3::from_array(*velocity_m_per_s),
                angular_velocity_rad_per_s: DVec3::from_array(angular_velocity_deg_per_s.map(f64::to_radians)),
            }),
            PathReport::Turntable { turntable } => Some(Trajectory::Turntable {
                centre_m: DVec3::from_array(turntable.centre_m),
                axis: DVec3::from_array(turntable.axis),
                speed_rad_per_s: turntable.speed_deg_per_s.to_radians(),
            }),
            PathReport::Poses { poses, interpolation } => {
                Trajectory::through(poses.iter().map(pose).collect(), (*interpolation).into(), "").ok()
            }
            PathReport::Still {} => None,
        };
        let unknown = Recording {
            motion,
            start_s: 0.0,
            exposure_s: self.exposure_s,
            row_time_s: self.row_time_s,
            first_row: self.first_row,
            duration_s: 0.0,
            frame_interval_s: self.frame_interval_s,
        };
        // The last row is at one of the edges.
        let end = |row: u32| unknown.time_s(f64::from(row), 1.0);
        Recording { duration_s: end(0).max(end(rows.saturating_sub(1))), ..unknown }
    }
}
