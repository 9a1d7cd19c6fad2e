//! `capture.json`: everything needed to reproduce a capture and to use its pictures.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use photosite::calibration::targets::PlacedTarget;
use photosite::calibration::truth::{Correspondence, TruthLayer, View};
use photosite::develop::SensorCalibration;
use photosite::io::capture::{NextPicture, TruthOutput};
use photosite::io::target_file::facts;
use photosite::optics::{
    Camera, CameraMotion, FieldOfView, Intrinsics, LensDescription, LensKind, Projection, Recording,
};
use photosite::scene::description::SceneDescription;
use photosite::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, Spectrum, TABLE_LEN};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The object that `capture.json` holds and `--json` prints.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) photosite_version: &'static str,
    pub(super) input: String,
    pub(super) overrides: Vec<String>,
    /// Every key that was given: the capture file, the sensor's preset and `--set`, laid over each other. With the files
    /// that it names it is a capture file again.
    pub(super) capture: serde_json::Value,
    pub(super) seed: u64,
    /// What was said of the light when it was traced: a [`TracedReport`].
    #[serde(flatten)]
    pub(super) traced: Map<String, Value>,
    pub(super) sensor: SensorReport,
    /// `null` where nothing is known of the lens.
    pub(super) image: Option<ImageReport>,
    pub(super) exposure: ExposureReport,
    /// File names in the output folder.
    pub(super) files: Vec<String>,
    pub(super) warnings: Vec<String>,
    /// Left out where the same input shall give the same bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) timings: Option<Timings>,
}

/// What holds for the light, whatever sensor it falls on.
#[derive(Serialize)]
pub(super) struct TracedReport {
    pub(super) camera: CameraReport,
    pub(super) lens: LensReport,
    pub(super) render: RenderReport,
    pub(super) scene_light: LightReport,
    /// Calibration targets in the scene.
    pub(super) targets: Vec<TargetReport>,
    /// `null` where none is written.
    pub(super) truth: Option<TruthReport>,
    /// Camera paths traced.
    pub(super) paths: u64,
    /// Left out where the same input shall give the same bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) paths_per_s: Option<f64>,
}

impl TracedReport {
    /// The keys of this in a report.
    pub(super) const KEYS: [&str; 8] =
        ["camera", "lens", "render", "scene_light", "targets", "truth", "paths", "paths_per_s"];

    pub(super) fn into_map(self) -> Map<String, Value> {
        let value = serde_json::to_value(self).expect("our own structures have string keys and finite numbers");
        if let Value::Object(map) = value { map } else { Map::new() }
    }
}

/// What the numbers of ground truth stand for.
#[derive(Serialize)]
pub(super) struct TruthReport {
    layers: Vec<&'static str>,
    /// What one step of depth in a PNG file stands for.
    depth_unit_mm: f64,
    /// Names of the objects, from number 1 on.
    instances: Vec<String>,
    /// Their frames → world, row by row without the last row; of those that move at the `pose_time_s` of the camera.
    instances_to_world: Vec<[[f64; 4]; 3]>,
    /// Names of the materials, from number 1 on.
    materials: Vec<String>,
    /// Whether there is a next picture, which flow leads to; without, no flow is valid. Left out without flow.
    #[serde(skip_serializing_if = "Option::is_none")]
    has_next: Option<bool>,
}

impl TruthReport {
    /// `None` where no truth is asked for.
    pub(super) fn new(output: &TruthOutput, scene: &SceneDescription, recording: Option<&Recording>) -> Option<Self> {
        let part = recording.map_or(0.0, |recording| recording.part(recording.middle_s()));
        (!output.layers.is_empty()).then(|| Self {
            layers: output.layers.iter().map(|layer| layer.name()).collect(),
            depth_unit_mm: output.depth_unit_m * 1e3,
            instances: scene.instances.iter().map(|instance| instance.name.clone()).collect(),
            instances_to_world: scene.instances.iter().map(|instance| placement(&instance.at(part))).collect(),
            materials: scene.materials.iter().map(|material| material.name.clone()).collect(),
            has_next: output.layers.contains(&TruthLayer::Flow).then(|| output.next != NextPicture::None),
        })
    }
}

/// Spectrum of all light of the scene, the largest value 1: what counts as white.
#[derive(Deserialize, Serialize)]
pub(super) struct LightReport {
    first_nm: f32,
    last_nm: f32,
    /// At every whole nanometre.
    relative: Vec<f64>,
}

impl LightReport {
    pub(super) fn new(light: &Spectrum) -> Self {
        // As many digits as a value of the table has.
        let short = |value: &f32| value.to_string().parse().unwrap_or(f64::from(*value));
        Self { first_nm: LAMBDA_MIN_NM, last_nm: LAMBDA_MAX_NM, relative: light.values().iter().map(short).collect() }
    }

    /// The spectrum, if it is all there.
    pub(super) fn spectrum(&self) -> Option<Spectrum> {
        let whole = self.first_nm == LAMBDA_MIN_NM && self.relative.len() == TABLE_LEN;
        let usable = whole && self.relative.iter().all(|value| value.is_finite() && *value >= 0.0);
        usable.then(|| Spectrum::from_fn(|lambda| self.relative[(lambda - f64::from(LAMBDA_MIN_NM)) as usize]))
    }
}

/// A calibration target: what is known of it, and where it stands.
#[derive(Serialize)]
pub(super) struct TargetReport {
    name: String,
    /// Its keys, its points and its markers in its own frame (x right, y down, z into the sheet).
    #[serde(flatten)]
    facts: Value,
    /// Target → world rotation, row by row: x_world = R·x_target + t.
    rotation: [[f64; 3]; 3],
    translation_m: [f64; 3],
    /// The points in the world (glTF axes, metres), in the same order.
    points_world_m: Vec<[f64; 3]>,
    /// Where they appear in the picture, through the whole lens: integer coordinates at pixel centres. `null` for those behind
    /// the camera. Where something moves: in the middle of the exposure of their rows of the first picture.
    points_px: Vec<Option<[f64; 2]>>,
    /// Whether they are within the picture, with nothing before them.
    points_visible: Vec<bool>,
}

impl TargetReport {
    pub(super) fn new(placed: &PlacedTarget, view: &View<'_>) -> Self {
        let found: Vec<_> = placed.points().map(|(_, point)| view.landmark(point)).collect();
        let px = |place: &Correspondence| (place.pixel - DVec2::splat(0.5)).to_array();
        Self {
            points_px: found.iter().map(|place| place.as_ref().map(px)).collect(),
            points_visible: found.iter().map(|place| place.is_some_and(|place| place.visible)).collect(),
            name: placed.name.clone(),
            facts: facts(&placed.description, &placed.target),
            rotation: rows(placed.to_world.matrix3),
            translation_m: placed.to_world.translation.to_array(),
            points_world_m: placed.points().map(|(_, point)| point.to_array()).collect(),
        }
    }
}

/// Rows of the matrix [R t].
fn placement(to_world: &DAffine3) -> [[f64; 4]; 3] {
    let (rotation, t) = (rows(to_world.matrix3), to_world.translation);
    [0, 1, 2].map(|i| [rotation[i][0], rotation[i][1], rotation[i][2], t[i] + 0.0])
}

/// Rows of a matrix. Adding zero makes zeros of negative ones.
fn rows(m: DMat3) -> [[f64; 3]; 3] {
    m.transpose().to_cols_array_2d().map(|row| row.map(|x| x + 0.0))
}

/// Pose and intrinsics in OpenCV's conventions: x right, y down, z forward; integer coordinates at pixel centres.
#[derive(Serialize)]
pub(super) struct CameraReport {
    resolution_px: [u32; 2],
    /// fx, 0, cx; 0, fy, cy; 0, 0, 1 row by row, with the skew in the first row.
    camera_matrix: [[f64; 3]; 3],
    /// The model of the lens, as `[lens]` names it.
    projection: &'static str,
    /// Its coefficients in OpenCV's order: k₁ k₂ p₁ p₂ k₃ (then k₄ k₅ k₆, then s₁ … s₄) of a rectilinear lens, k₁ … k₄ of
    /// a fisheye, k₁ k₂ p₁ p₂ of an omnidirectional lens.
    distortion: Vec<f64>,
    /// Mirror parameter of an omnidirectional lens.
    #[serde(skip_serializing_if = "Option::is_none")]
    xi: Option<f64>,
    field_of_view: FieldOfViewReport,
    /// When the camera stands as is said here, s from the start of the first picture: halfway between the start of its first
    /// row's exposure and the end of its last one's, as ground truth and what is told of targets are of the middle of exposures.
    /// `null` where nothing moves.
    pose_time_s: Option<f64>,
    /// World → camera rotation, row by row: x_camera = R·x_world + t.
    rotation: [[f64; 3]; 3],
    translation_m: [f64; 3],
    /// Where the centre of the lens stands in the world (glTF axes, metres).
    position_m: [f64; 3],
    /// How it moves. `null` where nothing does.
    motion: Option<MotionReport>,
}

/// Row y of frame k sees light from t = k·interval + (|y + ½ − first row| − ½)·row time on, for the exposure time.
#[derive(Serialize)]
struct MotionReport {
    #[serde(flatten)]
    path: PathReport,
    exposure_s: f64,
    row_time_s: f64,
    first_row: f64,
    frame_interval_s: f64,
}

/// The pose at the time t.
#[derive(Serialize)]
#[serde(untagged)]
enum PathReport {
    /// The scene moves, not the camera.
    Still {},
    /// position + velocity·(t − pose_time_s), and turned about the camera's own glTF axes.
    Steady { velocity_m_per_s: [f64; 3], angular_velocity_deg_per_s: [f64; 3] },
    /// Between two poses, position linear in t, rotation on the shortest way.
    Poses { poses: Vec<PoseReport> },
}

#[derive(Serialize)]
struct PoseReport {
    time_s: f64,
    position_m: [f64; 3],
    /// Camera (glTF axes) → world, as a quaternion x, y, z, w.
    rotation_xyzw: [f64; 4],
}

impl MotionReport {
    fn new(recording: &Recording) -> Self {
        let path = match &recording.motion {
            None => PathReport::Still {},
            Some(CameraMotion::Steady { velocity_m_per_s, angular_velocity_rad_per_s }) => PathReport::Steady {
                velocity_m_per_s: velocity_m_per_s.to_array(),
                angular_velocity_deg_per_s: angular_velocity_rad_per_s.to_array().map(f64::to_degrees),
            },
            Some(CameraMotion::Poses(poses)) => {
                let poses = poses.iter().map(|pose| PoseReport {
                    time_s: pose.time_s,
                    position_m: pose.position_m.to_array(),
                    rotation_xyzw: pose.rotation.to_array(),
                });
                PathReport::Poses { poses: poses.collect() }
            }
        };
        let Recording { exposure_s, row_time_s, first_row, frame_interval_s, .. } = *recording;
        Self { path, exposure_s, row_time_s, first_row, frame_interval_s }
    }
}

/// Where the model of the lens is one to one, and what of the picture sees something.
#[derive(Serialize)]
pub(super) struct FieldOfViewReport {
    /// From the left to the right edge and from the top to the bottom one; `null` where an edge sees nothing.
    across_deg: [Option<f64>; 2],
    /// Largest angle from the axis that the lens reaches.
    reach_deg: f64,
    /// Smallest and largest distance from the principal point at which that is.
    radius_px: [f64; 2],
    /// Whether every pixel sees something.
    covers_sensor: bool,
}

impl FieldOfViewReport {
    pub(super) fn new(field: &FieldOfView) -> Self {
        Self {
            across_deg: field.across_rad.map(|angle| angle.map(f64::to_degrees)),
            reach_deg: field.reach_rad.to_degrees(),
            radius_px: field.radius_px,
            covers_sensor: field.blind_px.is_none(),
        }
    }
}

/// The camera that `image.png` is a picture of, in the same conventions: that of `camera`, where the distortion of the lens is left in,
/// pixels keep their shape, and all of the sensor is read out pixel by pixel; else the one that a developer makes of it. It stands
/// where that one stands.
#[derive(Serialize)]
pub(super) struct ImageReport {
    pub(super) resolution_px: [usize; 2],
    /// Width of a pixel over its height.
    pub(super) pixel_aspect: f64,
    camera_matrix: [[f64; 3]; 3],
    projection: &'static str,
    distortion: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    xi: Option<f64>,
    /// Whether it shows things in other places than the raw picture does.
    is_resampled: bool,
}

impl ImageReport {
    pub(super) fn new(
        resolution_px: [usize; 2],
        pixel_aspect: f64,
        intrinsics: &Intrinsics,
        projection: &Projection,
        is_resampled: bool,
    ) -> Self {
        Self {
            resolution_px,
            pixel_aspect,
            camera_matrix: camera_matrix(intrinsics),
            projection: projection.name(),
            distortion: projection.coefficients(),
            xi: projection.xi(),
            is_resampled,
        }
    }
}

/// Row by row, with pixel centres at whole numbers.
fn camera_matrix(&Intrinsics { fx, fy, cx, cy, skew }: &Intrinsics) -> [[f64; 3]; 3] {
    [[fx, skew, cx - 0.5], [0.0, fy, cy - 0.5], [0.0, 0.0, 1.0]]
}

impl CameraReport {
    /// `camera` stands still, where it does halfway through the recording.
    pub(super) fn new(
        lens: &LensDescription,
        camera: &Camera,
        resolution_px: [u32; 2],
        recording: Option<&Recording>,
    ) -> Self {
        let DAffine3 { matrix3, translation } = camera.to_world();
        // glTF's camera looks along −z with y up.
        let flip = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
        let rotation = flip * matrix3.transpose();
        Self {
            resolution_px,
            camera_matrix: camera_matrix(&camera.intrinsics()),
            projection: lens.projection.name(),
            distortion: lens.projection.coefficients(),
            xi: lens.projection.xi(),
            field_of_view: FieldOfViewReport::new(&camera.field_of_view()),
            pose_time_s: recording.map(Recording::middle_s),
            rotation: rows(rotation),
            translation_m: (DVec3::ZERO - rotation * translation).to_array(),
            position_m: translation.to_array(),
            motion: recording.map(MotionReport::new),
        }
    }
}

#[derive(Serialize)]
pub(super) struct LensReport {
    pub(super) kind: &'static str,
    pub(super) focal_length_mm: f64,
    pub(super) f_number: f64,
    /// `null`: focused at infinity.
    pub(super) focus_distance_m: Option<f64>,
    /// Distance lens → sensor v.
    pub(super) image_distance_mm: f64,
}

impl LensReport {
    pub(super) fn new(lens: &LensDescription, camera: &Camera) -> Self {
        let focus = camera.focus_distance_m();
        Self {
            kind: match lens.kind {
                LensKind::Pinhole => "pinhole",
                LensKind::Thin => "thin",
            },
            focal_length_mm: lens.focal_length_m * 1e3,
            f_number: lens.f_number,
            focus_distance_m: focus.is_finite().then_some(focus),
            image_distance_mm: camera.image_distance_m() * 1e3,
        }
    }
}

#[derive(Serialize)]
pub(super) struct SensorReport {
    pub(super) name: String,
    /// Fixed pattern belongs to it.
    pub(super) serial: u64,
    pub(super) resolution_px: [usize; 2],
    pub(super) pixel_pitch_um: [f64; 2],
    pub(super) channels: Vec<String>,
    pub(super) bits: u32,
    pub(super) black_level_dn: f32,
    pub(super) white_level_dn: u16,
    /// What makes the numbers linear, which the levels are of; `null` where they are so already.
    pub(super) linearisation_dn: Option<Vec<u16>>,
    /// K at the exposure's gains.
    pub(super) system_gain_dn_per_e: f64,
    /// The smaller of full well and converter range at these gains.
    pub(super) saturation_capacity_e: f64,
    pub(super) read_noise_e: f64,
    pub(super) as_shot_neutral: Option<Vec<f64>>,
    pub(super) colour_matrix_d65: Option<Vec<[f64; 3]>>,
    /// What the channels mean in A, D65 and D50, so that another exposure need not find it again; `null` without colours.
    pub(super) calibration: Option<SensorCalibration>,
}

#[derive(Serialize)]
pub(super) struct ExposureReport {
    pub(super) time_s: f64,
    pub(super) auto: bool,
    pub(super) gain_db: f64,
    pub(super) digital_gain_db: f64,
    /// Saturation-based ISO speed at these gains; `null` for logarithmic sensors.
    pub(super) iso: Option<f64>,
    pub(super) temperature_c: f64,
    pub(super) frames: u32,
    /// The times of a bracket; `null` for none.
    pub(super) bracket_s: Option<Vec<f64>>,
}

#[derive(Serialize)]
pub(super) struct RenderReport {
    /// Of light transport; that of sensor noise is in the report itself.
    pub(super) seed: u64,
    pub(super) samples_per_pixel: u32,
    pub(super) max_depth: u32,
    pub(super) roulette_depth: u32,
    pub(super) splitting: u32,
    pub(super) reuse: u32,
    pub(super) light_paths: f64,
    pub(super) wavelengths: &'static str,
    pub(super) sampler: &'static str,
    pub(super) triangles: usize,
    pub(super) lights: usize,
    /// Root-mean-square Monte Carlo noise over root-mean-square sensor noise; `null` in the dark and after a
    /// single sample.
    pub(super) noise_ratio: Option<f64>,
    /// `null` without a noise target.
    pub(super) noise: Option<NoiseReport>,
}

/// What became of a noise target.
#[derive(Serialize)]
pub(super) struct NoiseReport {
    /// Monte Carlo noise over sensor noise in each pixel, standard deviations.
    pub(super) target: f64,
    /// Samples of the pixels of the picture.
    pub(super) samples_least: u32,
    pub(super) samples_mean: f64,
    pub(super) samples_most: u32,
    /// Samples a pixel beside those, from which their number was found.
    pub(super) pilot_samples_mean: f64,
    /// Part of the pixels, 0–1, whose measured ratio is at most the target.
    pub(super) pixels_at_target: f64,
    /// The ratio that 99 % of the pixels stay below; `null` where there is not enough light for an exposure.
    pub(super) ratio_of_99_percent: Option<f64>,
}

/// Wall-clock seconds of the steps.
#[derive(Clone, Copy, Default, Serialize)]
pub(super) struct Timings {
    pub(super) load_s: f64,
    pub(super) build_s: f64,
    pub(super) trace_s: f64,
    pub(super) expose_s: f64,
    pub(super) develop_s: f64,
    pub(super) write_s: f64,
}
