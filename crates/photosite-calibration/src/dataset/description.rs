//! The keys of a data set file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::PlaceDescription;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_transport::geometry::Interpolation;

/// Data set: a capture, and what differs from frame to frame.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "photosite data set")]
pub struct DatasetDescription {
    /// Capture file that all frames are made from, relative to this file.
    pub capture: String,
    /// Number of frames. Left out: as many as the poses ask for, else 1.
    #[schemars(transform = within(1.0..))]
    pub frames: Option<u32>,
    /// Seed of everything that is random. Left out: 0. The seed of each image is made from it, the number of the
    /// frame, the camera and `render.seed` of the capture, which gives other noise in the same frames.
    pub seed: Option<u32>,
    /// Changes to keys of the capture, for all frames, as overrides have them: "render.samples_per_pixel=64". Unless
    /// one of them says otherwise, `develop.distortion` and `develop.square_pixels` are false.
    #[serde(default)]
    pub set: Vec<String>,
    /// Cameras of a rig. Left out: one, called "camera".
    #[serde(default)]
    pub cameras: Vec<RigCameraDescription>,
    /// Poses of the rig. Left out: the pose of the capture's camera.
    pub poses: Option<PosesDescription>,
    /// Keys of the capture that differ from frame to frame.
    #[serde(default)]
    pub vary: Vec<VariationDescription>,
    /// Joint distribution of the values of `vary` over the frames. Left out: "independent".
    #[serde(default)]
    pub sampling: SamplingDescription,
    /// Objects that get other places in each frame, one table after the other: those of later tables keep clear of
    /// those of earlier ones.
    #[serde(default)]
    pub place: Vec<PlaceDescription>,
}

/// Joint distribution of random values over the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SamplingDescription {
    /// Independent draws for each frame. A longer set begins with the frames of a shorter one.
    #[default]
    Independent,
    /// Latin hypercube: the range of every number that is drawn is cut into as many equally likely parts as there are
    /// frames, and each part is that of one frame. Few frames cover their ranges evenly; another number of frames makes
    /// other ones. Sweeps and poses stay as they are.
    LatinHypercube,
}

/// Camera of a rig, in the axes of the rig: x right, y up, looking along −z.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigCameraDescription {
    /// Name of the camera and of its folder.
    pub name: String,
    /// Centre of its lens in the rig, m. Left out: [0, 0, 0].
    pub position_m: Option<[f64; 3]>,
    /// Point on its optical axis in the rig, m. Left out: straight ahead.
    pub look_at_m: Option<[f64; 3]>,
    /// Direction that is up in its image. Left out: [0, 1, 0].
    pub up: Option<[f64; 3]>,
    /// Changes to keys of the capture for this camera: "lens.focal_length_mm=8". Unless one of them is `sensor.serial`,
    /// cameras have the serial number of the capture and those that follow it, in the order of this list, each a fixed
    /// pattern of its own.
    #[serde(default)]
    pub set: Vec<String>,
    /// Name of the camera that `disparity` of ground truth leads to. Left out: `disparity` is left out of this camera's
    /// ground truth.
    pub disparity_to: Option<String>,
}

/// Poses of the rig in each frame, by one of these keys.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PosesDescription {
    /// Poses one after the other; from the first again where there are more frames.
    pub list: Option<Vec<PoseDescription>>,
    /// All combinations of directions and distances.
    pub grid: Option<GridPoses>,
    /// Poses drawn at random.
    pub random: Option<RandomPoses>,
    /// Poses along a way, at even intervals of time.
    pub trajectory: Option<TrajectoryPoses>,
}

/// Pose of the rig.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseDescription {
    /// Origin of the rig, m.
    pub position_m: [f64; 3],
    /// Point straight ahead, m.
    pub look_at_m: [f64; 3],
    /// Direction that is up. Left out: [0, 1, 0].
    pub up: Option<[f64; 3]>,
}

/// Views of a target, or of a point, from all combinations of these directions and distances. The last varies fastest.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GridPoses {
    /// Name of a target of the capture, whose middle is looked at from its front.
    pub target: Option<String>,
    /// Point in place of a target, looked at along the world's −z, m.
    pub look_at_m: Option<[f64; 3]>,
    /// Angles to the right, degrees. Left out: 0 alone.
    #[serde(default = "straight")]
    pub azimuth_deg: Vec<f64>,
    /// Angles upwards, degrees. Left out: 0 alone.
    #[serde(default = "straight")]
    pub elevation_deg: Vec<f64>,
    /// Distances, m.
    #[schemars(transform = above(0.0..))]
    pub distance_m: Vec<f64>,
}

fn straight() -> Vec<f64> {
    vec![0.0]
}

/// Views of a target, or of a point, drawn evenly from these ranges. The middle of the target is sent all over the
/// image, as near to its border as the whole target allows.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomPoses {
    /// Name of a target of the capture: all of its points stay in the images of all cameras.
    pub target: Option<String>,
    /// Point in place of a target that does so, m.
    pub look_at_m: Option<[f64; 3]>,
    /// Least and largest distance, m.
    #[schemars(transform = above(0.0..))]
    pub distance_m: [f64; 2],
    /// Least and largest angle from the target's front, or from the point's +z, degrees. Left out: [0, 45].
    #[schemars(transform = within(0.0..=89.0))]
    pub tilt_deg: Option<[f64; 2]>,
    /// Least and largest angle about the way of looking, degrees. Left out: [-10, 10].
    #[schemars(transform = within(-360.0..=360.0))]
    pub roll_deg: Option<[f64; 2]>,
    /// Distance that all points keep from the border of the image, px. Left out: 5.
    #[schemars(transform = within(0.0..))]
    pub margin_px: Option<f64>,
}

/// Trajectory through poses at times.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrajectoryPoses {
    /// Frames a second.
    #[schemars(transform = above(0.0..))]
    pub frame_rate_hz: f64,
    /// Poses in the order of their times.
    pub poses: Vec<TimedPoseDescription>,
    /// Interpolation from one pose to the next. Left out: "linear".
    pub interpolation: Option<InterpolationName>,
    /// Whether the rig moves while it records: blur, and the skew of rolling shutters. Left out: true.
    pub moving: Option<bool>,
}

/// Interpolation of a trajectory from one pose to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum InterpolationName {
    /// Straight at constant speed, turning evenly.
    #[default]
    Linear,
    /// Spline, whose velocity and angular velocity do not jump at any pose between the first and the last.
    Spline,
}

impl From<InterpolationName> for Interpolation {
    fn from(name: InterpolationName) -> Self {
        match name {
            InterpolationName::Linear => Self::Linear,
            InterpolationName::Spline => Self::Spline,
        }
    }
}

/// Pose of the rig at a time.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimedPoseDescription {
    /// Time from the start of the first frame, s.
    pub time_s: f64,
    /// Origin of the rig, m.
    pub position_m: [f64; 3],
    /// Point straight ahead, m.
    pub look_at_m: [f64; 3],
    /// Direction that is up. Left out: [0, 1, 0].
    pub up: Option<[f64; 3]>,
    /// Zoom: the focal length of all cameras at that time, mm, linear from one pose to the next. It stays for a frame
    /// as it is when the frame begins. Left out, of all poses: that of the capture.
    #[schemars(transform = above(0.0..))]
    pub focal_length_mm: Option<f64>,
}

/// Keys that differ from frame to frame, by one of these distributions.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VariationDescription {
    /// Key of the capture, such as "exposure.gain_db". Elements of lists go by name or number, as in
    /// "lights.key.intensity_cd". A part with `*` (any letters) or `?` (one letter) stands for all names that are like
    /// it, as in "materials.paint-*.roughness", and each of these keys gets a value of its own. Not with choices.
    pub key: Option<String>,
    /// Numbers drawn evenly between two.
    pub uniform: Option<[f64; 2]>,
    /// Numbers whose logarithm is drawn evenly between those of two.
    #[schemars(transform = above(0.0..))]
    pub log_uniform: Option<[f64; 2]>,
    /// Numbers drawn from a normal distribution of this mean and standard deviation.
    pub normal: Option<[f64; 2]>,
    /// Values of any kind, one of which is drawn.
    pub choice: Option<Vec<serde_json::Value>>,
    /// Tables of keys and their values, one of which is drawn, so that several keys vary together. All have the same
    /// keys: [{ "lights.key.intensity_cd" = 100, "lights.key.illuminant" = "A" }, …].
    pub choices: Option<Vec<serde_json::Map<String, serde_json::Value>>>,
    /// Files, one of which is drawn: a pattern such as "textures/*.png", relative to this file; `**` stands for folders
    /// of any depth. The key is one that names a file, such as "materials.wall.reflectance.texture" or
    /// "scene.environment.image".
    pub files: Option<String>,
    /// Weights of choice, choices or files in their order, of any sum. Left out: all equal.
    #[schemars(transform = within(0.0..))]
    pub weights: Option<Vec<f64>>,
    /// Numbers from the first to the last, evenly over the frames: focus and zoom sweeps.
    pub sweep: Option<[f64; 2]>,
    /// Lists of numbers, such as positions, drawn evenly between two corners: [[-1, 0, -1], [1, 2, 1]].
    pub r#box: Option<[Vec<f64>; 2]>,
    /// Positions on a sphere or a part of it, or directions: {} are all directions.
    pub sphere: Option<SphereDescription>,
    /// Rotations as quaternions w, x, y, z, for keys such as `quaternion_wxyz`: {} are all rotations, evenly.
    pub rotation: Option<RotationDescription>,
    /// Colours as displayed (sRGB), for keys such as `reflectance` and `rgb`.
    pub hsv: Option<HsvDescription>,
    /// Least and largest number of the keys that a pattern stands for which are true, and the others false. How many is
    /// drawn, then which: of "lights.*.on", how many lights are on.
    pub count: Option<[u32; 2]>,
    /// Whether all keys that a pattern stands for have the same value. Left out: false.
    #[serde(default)]
    pub together: bool,
    /// Whether each camera of the rig has a value of its own. Left out: false.
    #[serde(default)]
    pub per_camera: bool,
}

/// Points drawn evenly over a sphere, or a part of one.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereDescription {
    /// Middle of the sphere, m. Left out: [0, 0, 0].
    pub center_m: Option<[f64; 3]>,
    /// Least and largest radius, m; between two that differ, points are drawn evenly over the volume. Left out: [1, 1].
    #[schemars(transform = within(0.0..=1e18))]
    pub radius_m: Option<[f64; 2]>,
    /// Direction that angles are measured from. Left out: [0, 1, 0].
    pub up: Option<[f64; 3]>,
    /// Least and largest angle from `up`, degrees, 0–180: [0, 90] is the upper half. Left out: [0, 180].
    #[schemars(transform = within(0.0..=180.0))]
    pub angle_deg: Option<[f64; 2]>,
}

/// Rotations drawn evenly.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotationDescription {
    /// Axis of all rotations. Left out: any.
    pub axis: Option<[f64; 3]>,
    /// Least and largest angle about the axis, degrees. Left out: [0, 360].
    #[schemars(transform = within(-360.0..=360.0))]
    pub angle_deg: Option<[f64; 2]>,
}

/// Colours drawn evenly in hue, saturation and value, those of sRGB as displayed.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HsvDescription {
    /// Least and largest hue, degrees: 0 is red, 120 green, 240 blue; [330, 390] is red on both sides. Left out: [0,
    /// 360].
    #[schemars(transform = within(-360.0..=720.0))]
    pub hue_deg: Option<[f64; 2]>,
    /// Least and largest saturation, 0–1. Left out: [0, 1].
    #[schemars(transform = within(0.0..=1.0))]
    pub saturation: Option<[f64; 2]>,
    /// Least and largest value, the largest of R, G and B, 0–1. Left out: [0, 1].
    #[schemars(transform = within(0.0..=1.0))]
    pub value: Option<[f64; 2]>,
}

impl DatasetDescription {
    /// Whether the cameras zoom along a trajectory.
    pub fn zooms(&self) -> bool {
        let trajectory = self.poses.as_ref().and_then(|poses| poses.trajectory.as_ref());
        trajectory.is_some_and(|trajectory| trajectory.poses.iter().any(|pose| pose.focal_length_mm.is_some()))
    }
}
