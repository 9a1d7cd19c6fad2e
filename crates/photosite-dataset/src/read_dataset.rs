//! Data sets that `photosite dataset` has made, read back: the manifest and the reports of the images.
//!
//! In: the folder. Out: a [`ImageSet`], from which [layouts](photosite_calibration::layouts) are made.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec2, DVec3};
use serde::Deserialize;
use serde_json::Value;

use super::layout_folder::IMAGE;
use photosite_calibration::camera_files::CalibratedCamera;
use photosite_calibration::layouts::{EPOCH_NS, ImageSet, RollingShutter, SceneObject, SeenPoint, SeenTarget, Shot};
use photosite_capture::report::{PixelGridReport, REPORT, Report, TargetReport, TracedReport};
use photosite_core::input;
use photosite_core::{Error, Invalid, Result};
use photosite_files::file_sum::FileSum;
use photosite_transport::optics::{Projection, Recording};

/// Manifest of a data set: one line for each image.
pub(super) const MANIFEST: &str = "manifest.jsonl";

/// Reads a data set whose images are all there.
pub fn read_dataset(folder: &Path) -> Result<ImageSet> {
    let (set, frames) = read(folder)?;
    let all = frames as usize * set.cameras.len();
    if set.shots.len() != all || all == 0 {
        let message = format!("{} of {all} images exist", set.shots.len());
        let help = "run the command that makes the data set again: it continues where it stopped";
        return Err(Invalid::new("", message).help(help).in_file(&folder.join(MANIFEST)));
    }
    set.shots.iter().try_for_each(|shot| refuse_resampled(folder, shot))?;
    Ok(set)
}

/// Refuses an image that was resampled, since ground truth has everything in other places.
pub(super) fn refuse_resampled(folder: &Path, shot: &Shot) -> Result<()> {
    if !shot.is_resampled {
        return Ok(());
    }
    let message = "the image was developed in another size, or without the distortion or the shape of pixels, that its \
                   camera and its ground truth have";
    let invalid = Invalid::new("capture.develop", message);
    let help = "make the data set without setting develop.distortion, develop.square_pixels, develop.resize_px and \
                develop.digital_zoom";
    Err(invalid.help(help).in_file(&folder.join(&shot.folder).join(REPORT)))
}

/// Reads the images of a data set that are there.
pub fn read_present(folder: &Path) -> Result<ImageSet> {
    read(folder).map(|(set, _)| set)
}

/// Reads the images that are there, and the number of frames of the whole data set.
fn read(folder: &Path) -> Result<(ImageSet, u32)> {
    let path = folder.join(MANIFEST);
    if !path.is_file() {
        let help = "give the folder that `photosite dataset` has filled to the end";
        return Err(Invalid::new("", format!("has no {MANIFEST}")).help(help).in_file(folder));
    }
    let text = input::read_text(&path, input::TABLE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
    let mut set = ImageSet { folder: folder.to_owned(), cameras: Vec::new(), shots: Vec::new() };
    let mut frames = 0;
    for (number, line) in (1..).zip(text.lines()) {
        let line: Line = serde_json::from_str(line).map_err(|e| {
            let help = "run the command that makes the data set again, which writes it again";
            Invalid::new("", format!("is damaged: {e}")).help(help).at_line(&path, number)
        })?;
        let camera = set.cameras.iter().position(|name| *name == line.camera).unwrap_or_else(|| {
            set.cameras.push(line.camera.clone());
            set.cameras.len() - 1
        });
        frames = line.frames;
        let path = folder.join(&line.folder).join(REPORT);
        set.shots.push(shot(&path, Report::read(&path)?, line, camera)?);
    }
    Ok((set, frames))
}

/// Line of the manifest.
#[derive(Deserialize)]
pub(super) struct Line {
    pub(super) frame: u32,
    pub(super) frames: u32,
    pub(super) camera: String,
    pub(super) time_s: Option<f64>,
    pub(super) folder: String,
    /// Checksums of the image's files; empty in manifests of earlier versions.
    #[serde(default)]
    pub(super) sums: BTreeMap<String, FileSum>,
}

/// Reads the report of an image, at `path`.
pub(super) fn shot(path: &Path, report: Report, line: Line, camera: usize) -> Result<Shot> {
    let damaged = |why: &str| {
        let help = "remove its folder, and run the command that makes the data set again";
        Invalid::new("", format!("is damaged: {why}")).help(help).in_file(path)
    };
    let TracedReport { camera: Some(reported), targets, truth, .. } = report.traced else {
        return Err(damaged("it says nothing of the camera"));
    };
    let projection =
        reported.projection().ok_or_else(|| damaged(&format!("there is no projection {:?}", reported.projection)))?;
    let reported_pose = reported.to_world();
    // Earlier reports have the pose at time 0.
    let reported_s = reported.pose_time_s.unwrap_or(0.0);
    let recording = reported.motion.as_ref().map(|motion| motion.recording(reported.resolution_px[1]));
    let time_s = recording.as_ref().map_or(0.0, Recording::middle_s);
    let pose = |time_s: f64| match recording.as_ref().and_then(|recording| recording.motion.as_ref()) {
        None => reported_pose,
        Some(motion) => motion.pose_from(&reported_pose, reported_s, time_s),
    };
    // Short against any change of a velocity, and long against the last bits of a position.
    const STEP_S: f64 = 1e-4;
    let velocity = (pose(time_s + STEP_S).translation - pose(time_s).translation) / STEP_S;
    // Earlier versions had truth on all pixels of the sensor, whatever the image showed.
    let grid = report.pixel_grid.as_ref().map_or_else(|| reported.resolution_px.into(), PixelGridReport::grid);
    let rows = f64::from(grid.resolution[1]);
    let sensor_row = |row: f64| grid.on_sensor(DVec2::new(0.0, row + 0.5)).y - 0.5;
    let shutter = recording.as_ref().filter(|recording| recording.motion.is_some() && recording.row_time_s != 0.0);
    let shutter = shutter.filter(|_| rows > 1.0).map(|recording| RollingShutter {
        rows: [0.0, rows - 1.0].map(|row| pose(recording.time_s(sensor_row(row), 0.5))),
        exposure: recording.exposure_s / ((rows - 1.0) * grid.per_pixel.y * recording.row_time_s),
        is_downwards: recording.first_row == 0.0,
    });
    let since_start_s = line.time_s.unwrap_or(f64::from(line.frame)) + time_s;
    // Reports that say nothing of it are of a time when this lens's distortion alone was undone.
    let undid_distortion = || {
        matches!(projection, Projection::BrownConrady(_))
            && report.capture.pointer("/develop/distortion") != Some(&Value::Bool(false))
    };
    let has_image = report.files.iter().any(|file| file == IMAGE);
    let is_resampled = has_image
        && match (&report.image, &report.pixel_grid) {
            (None, _) => undid_distortion(),
            (Some(image), None) => image.is_resampled,
            (Some(image), Some(grid)) => !grid.is_of(image, &projection),
        };
    Ok(Shot {
        folder: line.folder,
        frame: line.frame,
        camera,
        stamp_ns: EPOCH_NS + (since_start_s * 1e9).round() as u64,
        calibrated: CalibratedCamera {
            name: line.camera,
            intrinsics: grid.intrinsics(&reported.intrinsics()),
            projection,
            resolution: grid.resolution,
            to_world: pose(time_s),
        },
        start: pose(0.0),
        velocity_m_per_s: velocity,
        is_resampled,
        shutter,
        is_skewed: recording.is_some_and(|recording| recording.row_time_s != 0.0),
        targets: targets.into_iter().flatten().map(seen).collect(),
        objects: truth.map_or_else(Vec::new, |truth| SceneObject::of_numbers(truth.objects())),
    })
}

/// Target as an image shows it.
fn seen(target: TargetReport) -> SeenTarget {
    let to_world = target.to_world();
    let places = target.points_world_m.into_iter().zip(target.points_px);
    let points = target.facts.points.into_iter().zip(places).zip(target.points_visible);
    let seen = points.map(|((point, (world, pixel)), is_visible)| SeenPoint {
        name: point.name,
        world: DVec3::from_array(world),
        pixel: pixel.map(DVec2::from_array),
        is_visible,
    });
    SeenTarget { name: target.name, description: target.facts.target, to_world, points: seen.collect() }
}
