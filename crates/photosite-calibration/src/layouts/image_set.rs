//! Images of a data set with everything known about them, and the interface by which layouts read and write files.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::super::camera_files::CalibratedCamera;
use super::super::targets::TargetDescription;
use super::super::truth::TruthLayer;
use super::objects::SceneObject;
use photosite_core::image::Planes;
use photosite_core::{Error, Invalid, Result};
use photosite_transport::scene::description::SceneDescription;

/// Images of a data set.
#[derive(Clone, Debug)]
pub struct ImageSet {
    /// Folder of the data set, for messages.
    pub folder: PathBuf,
    /// Names of the cameras of the rig.
    pub cameras: Vec<String>,
    /// Images, sorted by frame and then by camera.
    pub shots: Vec<Shot>,
}

/// Image with everything known about it.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Folder of the image, relative to that of the data set.
    pub folder: String,
    /// Number of the frame.
    pub frame: u32,
    /// Index of the camera.
    pub camera: usize,
    /// Time stamp: the middle of the exposure of the middle row, from [`EPOCH_NS`] on, ns. Where frames have no times,
    /// they are taken a second apart.
    pub stamp_ns: u64,
    /// Camera at the time stamp.
    pub calibrated: CalibratedCamera,
    /// Camera → world at the start of the frame.
    pub start: DAffine3,
    /// Velocity of the centre of the lens in the world, m/s.
    pub velocity_m_per_s: DVec3,
    /// Whether the developed image shows points in other places than the camera saw them, without its distortion or
    /// with square pixels.
    pub is_resampled: bool,
    /// Whether rows are exposed one after the other while something moves.
    pub is_skewed: bool,
    /// Poses of the camera while rows are exposed one after the other; `None` where it stands still, or all rows are
    /// exposed at the same time.
    pub shutter: Option<RollingShutter>,
    /// Calibration targets in the scene.
    pub targets: Vec<SeenTarget>,
    /// Objects of ground truth; empty where none was requested.
    pub objects: Vec<SceneObject>,
}

impl Shot {
    /// Time of the image from the start of the first frame, s.
    pub fn since_epoch_s(&self) -> f64 {
        (self.stamp_ns - EPOCH_NS) as f64 * 1e-9
    }
}

/// Camera that moves while its rows are exposed one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct RollingShutter {
    /// Camera → world in the middle of the exposure of the top row and of the bottom one.
    pub rows: [DAffine3; 2],
    /// Exposure time as a part of the time from the top row to the bottom one.
    pub exposure: f64,
    /// Whether rows are read out from top to bottom, not from the middle outwards.
    pub is_downwards: bool,
}

/// Time stamp of the start of the first frame, ns: tools take seconds and nanoseconds from fixed digits of the number,
/// and sort names of files as text.
pub const EPOCH_NS: u64 = 1_000_000_000_000_000_000;

/// Target in an image.
#[derive(Clone, Debug)]
pub struct SeenTarget {
    /// Name of the target.
    pub name: String,
    /// Description of the target.
    pub description: TargetDescription,
    /// Target → world.
    pub to_world: DAffine3,
    /// Points of the target.
    pub points: Vec<SeenPoint>,
}

/// Point of a target in an image.
#[derive(Clone, Debug)]
pub struct SeenPoint {
    /// Name of the point within the target.
    pub name: String,
    /// Position in the world, m.
    pub world: DVec3,
    /// Pixel in the image, integer coordinates at pixel centres; `None` behind the camera.
    pub pixel: Option<DVec2>,
    /// Whether the point is within the image and not occluded.
    pub is_visible: bool,
}

impl ImageSet {
    /// Images of a camera.
    pub fn of_camera(&self, camera: usize) -> impl Iterator<Item = &Shot> {
        self.shots.iter().filter(move |shot| shot.camera == camera)
    }

    /// Cameras of the rig at the start of the first frame, if they and their places on the rig are the same in all
    /// frames.
    pub fn rig(&self) -> Result<Vec<CalibratedCamera>, Invalid> {
        /// Tolerance of equal poses, m and sines of angles: poses go through decimal numbers and rotations of a few
        /// roundings, and no rig is known as well as that.
        const SAME: f64 = 1e-9;
        let mut rig = Vec::new();
        for (camera, name) in self.cameras.iter().enumerate() {
            let mut shots = self.of_camera(camera);
            let Some(first) = shots.next() else { continue };
            let differs = |what: &str, shot: &Shot, help: &str| {
                let message = format!("{what} of {name} in frame {} is not that in frame {}", shot.frame, first.frame);
                Invalid::new("", message).help(help)
            };
            for (shot, head) in shots.zip(self.of_camera(0).skip(1)) {
                if !is_same_lens(&shot.calibrated, &first.calibrated) {
                    let help = "one camera has to represent all frames: make a data set that varies neither lens nor \
                                sensor, with lens.focus_distance_m in place of autofocus, or lay this one out for colmap, \
                                which has a camera for each";
                    return Err(differs("the lens", shot, help));
                }
                let place = |shot: &Shot, head: &Shot| head.start.inverse() * shot.start;
                let Some(first_head) = self.of_camera(0).next() else { continue };
                if !place(shot, head).abs_diff_eq(place(first, first_head), SAME) {
                    let help = "the cameras of a rig must keep their places on it: make a data set that does not vary \
                                them, or lay this one out for colmap";
                    return Err(differs("the place on the rig", shot, help));
                }
            }
            rig.push(CalibratedCamera { to_world: first.start, ..first.calibrated.clone() });
        }
        Ok(rig)
    }

    /// Error of the data set as a whole.
    pub(super) fn error(&self, invalid: Invalid) -> Error {
        invalid.in_file(&self.folder)
    }
}

/// Whether two cameras differ in nothing but their poses.
pub(super) fn is_same_lens(a: &CalibratedCamera, b: &CalibratedCamera) -> bool {
    (a.intrinsics, a.projection, a.resolution) == (b.intrinsics, b.projection, b.resolution)
}

/// Files that a layout reads and writes. Paths are relative to the folder of the layout, with slashes.
pub trait LayoutFiles {
    /// Writes text.
    fn write_text(&mut self, path: &str, text: &str) -> Result<()>;
    /// Copies the developed image.
    fn copy_image(&mut self, path: &str, shot: &Shot) -> Result<()>;
    /// Writes the developed image as 8-bit grey PNG.
    fn write_grey_image(&mut self, path: &str, shot: &Shot) -> Result<()>;
    /// Whether the developed image is grey.
    fn is_grey(&mut self, shot: &Shot) -> Result<bool>;
    /// Writes a mask as 8-bit grey PNG: 255 within, 0 without.
    fn write_mask(&mut self, path: &str, size: [u32; 2], inside: &[bool]) -> Result<()>;
    /// Writes 16-bit grey PNG.
    fn write_grey16(&mut self, path: &str, size: [u32; 2], values: &[u16]) -> Result<()>;
    /// Writes an array of (rows, columns) `float32` as NPY.
    fn write_npy(&mut self, path: &str, size: [u32; 2], values: &[f32]) -> Result<()>;
    /// Warns once of what a layout leaves out.
    fn warn(&mut self, message: &str);
    /// Whether there is ground truth of these layers.
    fn has_truth(&mut self, shot: &Shot, layers: &[TruthLayer]) -> Result<bool>;
    /// Reads ground truth.
    fn truth(&mut self, shot: &Shot, layers: &[TruthLayer]) -> Result<Planes>;
    /// Reads the key points of each object that has any, by its number in ground truth.
    fn object_points(&mut self, _shot: &Shot) -> Result<Vec<(u32, Vec<SeenPoint>)>> {
        Ok(Vec::new())
    }
    /// Reads the geometry. The same scene is the same [`Arc`].
    fn scene(&mut self, shot: &Shot) -> Result<Arc<SceneDescription>>;
}
