//! What `photosite dataset` has made, read back: its manifest and the reports of its pictures.
//!
//! In: the folder. Out: a [`PictureSet`], from which [layouts](crate::calibration::layouts) are made.

use std::fs;
use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use serde::Deserialize;
use serde::de::DeserializeSeed;
use serde_json::Value;

use crate::calibration::camera_files::CalibratedCamera;
use crate::calibration::layouts::{EPOCH_NS, PictureSet, SceneObject, SeenPoint, SeenTarget, Shot};
use crate::calibration::targets::{TargetDescription, TargetKind};
use crate::io::capture::REPORT;
use crate::optics::{CameraMotion, Intrinsics, Projection, Recording, TimedPose};
use crate::{Error, Invalid, Result};

/// The list of pictures in the folder of a data set, a line each.
pub const MANIFEST: &str = "manifest.jsonl";

/// Reads a data set all of whose pictures are there.
pub fn read_dataset(folder: &Path) -> Result<PictureSet> {
    let (set, frames) = read(folder)?;
    let all = frames as usize * set.cameras.len();
    if set.shots.len() != all || all == 0 {
        let message = format!("{} of {all} pictures are there", set.shots.len());
        let help = "give the command that makes the data set again: it goes on where it stopped";
        return Err(Invalid::new("", message).help(help).in_file(&folder.join(MANIFEST)));
    }
    if let Some(shot) = set.shots.iter().find(|shot| shot.is_resampled) {
        let message = "the picture was developed without the distortion, or the shape of pixels, that its camera and its ground \
                       truth have";
        let invalid = Invalid::new("capture.develop", message);
        let help = "make the data set without setting develop.distortion and develop.square_pixels";
        return Err(invalid.help(help).in_file(&folder.join(&shot.folder).join(REPORT)));
    }
    Ok(set)
}

/// Reads those pictures of a data set that are there.
pub fn read_present(folder: &Path) -> Result<PictureSet> {
    read(folder).map(|(set, _)| set)
}

/// With the number of frames that the whole has.
fn read(folder: &Path) -> Result<(PictureSet, u32)> {
    let path = folder.join(MANIFEST);
    if !path.is_file() {
        let help = "give the folder that `photosite dataset` has filled to the end";
        return Err(Invalid::new("", format!("holds no {MANIFEST}")).help(help).in_file(folder));
    }
    let text = fs::read_to_string(&path).map_err(|reason| Error::io(&path, "read", reason))?;
    let mut set = PictureSet { folder: folder.to_owned(), cameras: Vec::new(), shots: Vec::new() };
    let mut frames = 0;
    for (number, line) in (1..).zip(text.lines()) {
        let line: Line = serde_json::from_str(line).map_err(|e| {
            let help = "give the command that makes the data set again, which writes it anew";
            Invalid::new("", format!("is damaged: {e}")).help(help).at_line(&path, number)
        })?;
        let camera = set.cameras.iter().position(|name| *name == line.camera).unwrap_or_else(|| {
            set.cameras.push(line.camera.clone());
            set.cameras.len() - 1
        });
        frames = line.frames;
        let report = folder.join(&line.folder).join(REPORT);
        set.shots.push(shot(&report, line, camera)?);
    }
    Ok((set, frames))
}

/// A line of the manifest.
#[derive(Deserialize)]
struct Line {
    frame: u32,
    frames: u32,
    camera: String,
    time_s: Option<f64>,
    folder: String,
}

/// What is read of a report.
#[derive(Deserialize)]
struct Report {
    camera: CameraBlock,
    targets: Vec<TargetBlock>,
    truth: Option<TruthBlock>,
    image: Option<ImageBlock>,
    capture: Value,
}

#[derive(Deserialize)]
struct ImageBlock {
    is_resampled: bool,
}

#[derive(Deserialize)]
struct CameraBlock {
    resolution_px: [u32; 2],
    camera_matrix: [[f64; 3]; 3],
    projection: String,
    distortion: Vec<f64>,
    xi: Option<f64>,
    /// Earlier reports have the pose at time 0.
    #[serde(default)]
    pose_time_s: Option<f64>,
    rotation: [[f64; 3]; 3],
    position_m: [f64; 3],
    motion: Option<MotionBlock>,
}

#[derive(Deserialize)]
struct MotionBlock {
    velocity_m_per_s: Option<[f64; 3]>,
    angular_velocity_deg_per_s: Option<[f64; 3]>,
    poses: Option<Vec<PoseBlock>>,
    exposure_s: f64,
    row_time_s: f64,
    first_row: f64,
    frame_interval_s: f64,
}

#[derive(Deserialize)]
struct PoseBlock {
    time_s: f64,
    position_m: [f64; 3],
    rotation_xyzw: [f64; 4],
}

#[derive(Deserialize)]
struct TargetBlock {
    name: String,
    target: Value,
    points: Vec<PointBlock>,
    rotation: [[f64; 3]; 3],
    translation_m: [f64; 3],
    points_world_m: Vec<[f64; 3]>,
    points_px: Vec<Option<[f64; 2]>>,
    points_visible: Vec<bool>,
}

#[derive(Deserialize)]
struct PointBlock {
    name: String,
}

#[derive(Deserialize)]
struct TruthBlock {
    instances: Vec<String>,
    instances_to_world: Vec<[[f64; 4]; 3]>,
}

fn shot(path: &Path, line: Line, camera: usize) -> Result<Shot> {
    let damaged = |why: &str| {
        let help = "remove its folder, and give the command that makes the data set again";
        Invalid::new("", format!("is damaged: {why}")).help(help).in_file(path)
    };
    let bytes = fs::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    let report: Report = serde_json::from_slice(&bytes).map_err(|e| damaged(&e.to_string()))?;
    let block = report.camera;
    let projection = Projection::named(&block.projection, &block.distortion, block.xi)
        .ok_or_else(|| damaged(&format!("there is no projection {:?}", block.projection)))?;
    let [[fx, skew, cx], [_, fy, cy], _] = block.camera_matrix;
    // glTF's camera looks along −z with y up.
    let axes = matrix(&block.rotation).transpose() * DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
    let told = DAffine3::from_mat3_translation(axes, DVec3::from_array(block.position_m));
    let told_s = block.pose_time_s.unwrap_or(0.0);
    let recording = block.motion.map(|motion| motion.recording(block.resolution_px[1]));
    let time_s = recording.as_ref().map_or(0.0, Recording::middle_s);
    let pose = |time_s: f64| match recording.as_ref().and_then(|recording| recording.motion.as_ref()) {
        None => told,
        Some(motion @ CameraMotion::Steady { .. }) => motion.pose(&told, time_s - told_s),
        Some(motion @ CameraMotion::Poses(_)) => motion.pose(&told, time_s),
    };
    // Short against any change of a velocity, and long against the last bits of a position.
    const STEP_S: f64 = 1e-4;
    let velocity = (pose(time_s + STEP_S).translation - pose(time_s).translation) / STEP_S;
    let since_start_s = line.time_s.unwrap_or(f64::from(line.frame)) + time_s;
    // Reports that say nothing of it are of a time when this lens's distortion alone was undone.
    let undid_distortion = || {
        matches!(projection, Projection::BrownConrady(_))
            && report.capture["develop"]["distortion"] != Value::Bool(false)
    };
    let is_resampled = report.image.map_or_else(undid_distortion, |image| image.is_resampled);
    Ok(Shot {
        folder: line.folder,
        frame: line.frame,
        camera,
        stamp_ns: EPOCH_NS + (since_start_s * 1e9).round() as u64,
        calibrated: CalibratedCamera {
            name: line.camera,
            intrinsics: Intrinsics { fx, fy, cx: cx + 0.5, cy: cy + 0.5, skew },
            projection,
            resolution: block.resolution_px,
            to_world: pose(time_s),
        },
        start: pose(0.0),
        velocity_m_per_s: velocity,
        is_resampled,
        is_skewed: recording.is_some_and(|recording| recording.row_time_s != 0.0),
        targets: report
            .targets
            .into_iter()
            .map(|target| target.seen().ok_or_else(|| damaged("a target is none that is known")))
            .collect::<Result<_>>()?,
        objects: report.truth.map_or_else(Vec::new, TruthBlock::objects),
    })
}

/// A matrix of these rows.
fn matrix(rows: &[[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(rows).transpose()
}

impl MotionBlock {
    /// Of a picture of so many rows.
    fn recording(self, rows: u32) -> Recording {
        let steady =
            self.velocity_m_per_s.zip(self.angular_velocity_deg_per_s).map(|(velocity, turn)| CameraMotion::Steady {
                velocity_m_per_s: DVec3::from_array(velocity),
                angular_velocity_rad_per_s: DVec3::from_array(turn.map(f64::to_radians)),
            });
        let pose = |pose: PoseBlock| TimedPose {
            time_s: pose.time_s,
            position_m: DVec3::from_array(pose.position_m),
            rotation: DQuat::from_array(pose.rotation_xyzw),
        };
        let poses = self.poses.map(|poses| CameraMotion::Poses(poses.into_iter().map(pose).collect()));
        let unknown = Recording {
            motion: steady.or(poses),
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

impl TargetBlock {
    fn seen(self) -> Option<SeenTarget> {
        let description = description(self.target)?;
        let places = self.points_world_m.into_iter().zip(self.points_px);
        let points = self.points.into_iter().zip(places).zip(self.points_visible);
        let seen = points.map(|((point, (world, pixel)), is_visible)| SeenPoint {
            name: point.name,
            world: DVec3::from_array(world),
            pixel: pixel.map(DVec2::from_array),
            is_visible,
        });
        Some(SeenTarget {
            name: self.name,
            description,
            to_world: DAffine3::from_mat3_translation(matrix(&self.rotation), DVec3::from_array(self.translation_m)),
            points: seen.collect(),
        })
    }
}

/// The keys of a target, of which `type` says what the others are.
fn description(mut keys: Value) -> Option<TargetDescription> {
    let kind = keys.as_object_mut()?.shift_remove("type")?;
    serde_json::from_value::<TargetKind>(kind).ok()?.deserialize(keys).ok()
}

impl TruthBlock {
    fn objects(self) -> Vec<SceneObject> {
        let place = |rows: [[f64; 4]; 3]| {
            let matrix = DMat3::from_cols_array_2d(&rows.map(|[x, y, z, _]| [x, y, z])).transpose();
            DAffine3::from_mat3_translation(matrix, DVec3::from_array(rows.map(|[.., t]| t)))
        };
        SceneObject::of_instances(self.instances.into_iter().zip(self.instances_to_world.into_iter().map(place)))
    }
}
