//! `objects.json`: the objects of an image.

use glam::{DAffine3, DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::matrix::{from_rows, rows};
use photosite_calibration::layouts::SeenPoint;
use photosite_calibration::truth::{Correspondence, Mask, Silhouettes, TruthObject, View, silhouettes};

/// The objects of an image. Pixels are those of ground truth; integer coordinates are at their centres.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct ObjectsReport {
    /// Columns and rows.
    pub resolution_px: [u32; 2],
    /// The objects, in the order of their numbers in the layer "instance".
    pub objects: Vec<ObjectReport>,
}

/// An object. Its frame is that of its file, turned and moved but not scaled. Where something moves, poses are those
/// halfway through the image, and masks and points those in the middle of the exposure of each row.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct ObjectReport {
    /// Number of the object in the layer "instance".
    pub number: u32,
    /// Name of the object.
    pub name: String,
    /// Category of the object; `null` for what was not placed as an object.
    pub category: Option<String>,
    /// Factors along the object's axes by which it is larger than in its file.
    pub scale: [f64; 3],
    /// Rotation R of x_world = R·x + t from the object's frame to the world, row by row.
    pub rotation_to_world: [[f64; 3]; 3],
    /// Translation t of x_world = R·x + t, m.
    pub position_m: [f64; 3],
    /// Rotation R of x_camera = R·x + t from the object's frame to the camera in OpenCV's axes (x right, y down, z
    /// forward), row by row.
    pub rotation: [[f64; 3]; 3],
    /// Translation t of x_camera = R·x + t, m.
    pub translation_m: [f64; 3],
    /// Smaller corner of the object's bounding box in its own frame, m.
    pub box_low_m: [f64; 3],
    /// Larger corner of the object's bounding box in its own frame, m.
    pub box_high_m: [f64; 3],
    /// Corners of the bounding box in the world, m: number i has the larger x if bit 0 of i is set, y bit 1, z bit 2.
    pub box_corners_world_m: [[f64; 3]; 8],
    /// Pixels at which the corners appear in the image, through the whole lens; `null` for those behind the camera.
    pub box_corners_px: [Option<[f64; 2]>; 8],
    /// Pixels that see the object.
    pub visible: MaskReport,
    /// Pixels that would see the object if nothing else were there.
    pub alone: MaskReport,
    /// Visible part of the object: pixels that see it over pixels that would see it alone; `null` where none would.
    pub visible_part: Option<f64>,
    /// Whether the object's box reaches beyond the part of the image that sees light (its edges, the image circle of
    /// sensor and lens), so that more of it may be outside.
    pub is_cut_off: bool,
    /// Key points of the object.
    pub keypoints: Vec<KeypointReport>,
}

/// Mask: a set of pixels.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct MaskReport {
    /// Number of the pixels.
    pub pixels: u64,
    /// Bounding box of the pixels: the first column and row, and the number of columns and rows; `null` for no pixel.
    pub box_px: Option<[u32; 4]>,
    /// Pixels as run lengths, as in COCO.
    pub mask: RunLengths,
}

/// A mask as lengths of runs down its columns: outside and inside in turns, outside first (COCO's uncompressed RLE).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct RunLengths {
    /// Rows and columns.
    pub size: [u32; 2],
    /// Lengths of the runs.
    pub counts: Vec<u32>,
}

/// Key point of an object.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct KeypointReport {
    /// Name of the key point.
    pub name: String,
    /// Position of the key point in the frame of the object, m.
    pub position_m: [f64; 3],
    /// Pixel at which the key point appears, through the whole lens; `null` behind the camera.
    pub px: Option<[f64; 2]>,
    /// Whether the key point is within the image, with nothing before it.
    pub visible: bool,
}

impl ObjectsReport {
    /// Report of the objects of the view's scene, in their order.
    pub fn new(view: &View<'_>, objects: &[TruthObject]) -> Self {
        let found = silhouettes(view, objects);
        let report = |(number, (object, found))| ObjectReport::new(number, object, &found, view);
        Self {
            resolution_px: view.grid.resolution,
            objects: (1..).zip(objects.iter().zip(found)).map(report).collect(),
        }
    }

    /// Warning of objects within the image that no pixel would see even if they were alone.
    pub fn warning(&self) -> Option<String> {
        let is_lost = |object: &&ObjectReport| !object.is_cut_off && object.alone.pixels == 0;
        let mut lost = self.objects.iter().filter(is_lost);
        let ObjectReport { name, number, .. } = lost.next()?;
        let more = match lost.count() {
            0 => String::new(),
            n => format!(" (as {n} more)"),
        };
        Some(format!(
            "the object {name:?}, number {number}, lies within the image, but no pixel would see it even alone{more}: it \
             is transparent, seen from behind, or smaller than a pixel; objects.json lists it with 0 pixels"
        ))
    }
}

impl ObjectReport {
    fn new(number: u32, object: &TruthObject, Silhouettes { visible, alone }: &Silhouettes, view: &View<'_>) -> Self {
        let halfway = view.camera.halfway();
        let to_world = object.to_world(halfway.pose_at_row(0.0).1);
        // OpenCV's camera looks along +z, with y down.
        let to_opencv = DAffine3::from_scale(DVec3::new(1.0, -1.0, -1.0));
        let to_camera = to_opencv * halfway.to_world().inverse() * to_world;
        let appears = |point: DVec3| view.moving_landmark(|time| object.to_world(time).transform_point3(point));
        let px = |found: &Correspondence| (found.pixel - DVec2::splat(0.5)).to_array();
        let corners = object.corners().map(&appears);
        let [width, height] = view.grid.resolution.map(f64::from);
        let is_inside = |found: &Correspondence| {
            let within = (0.0..=width).contains(&found.pixel.x) && (0.0..=height).contains(&found.pixel.y);
            within && view.camera.is_lit(found.on_sensor)
        };
        let of_point = |(name, point): &(String, DVec3)| {
            let found = appears(*point);
            KeypointReport {
                name: name.clone(),
                position_m: point.to_array(),
                px: found.as_ref().map(px),
                visible: found.is_some_and(|found| found.visible),
            }
        };
        let [seen, all] = [visible, alone].map(|mask| MaskReport::new(mask, view.grid.resolution));
        Self {
            number,
            name: object.name.clone(),
            category: object.category.clone(),
            scale: object.scale.to_array(),
            rotation_to_world: rows(to_world.matrix3),
            position_m: to_world.translation.to_array(),
            rotation: rows(to_camera.matrix3),
            translation_m: to_camera.translation.to_array(),
            box_low_m: object.low.to_array(),
            box_high_m: object.high.to_array(),
            box_corners_world_m: object.corners().map(|corner| to_world.transform_point3(corner).to_array()),
            box_corners_px: corners.map(|corner| corner.as_ref().map(px)),
            visible_part: (all.pixels > 0).then(|| seen.pixels as f64 / all.pixels as f64),
            visible: seen,
            alone: all,
            is_cut_off: !corners.iter().all(|corner| corner.as_ref().is_some_and(is_inside)),
            keypoints: object.keypoints.iter().map(of_point).collect(),
        }
    }
}

impl ObjectReport {
    /// Key points of the object in the image.
    pub fn seen_points(&self) -> Vec<SeenPoint> {
        let to_world = from_rows(&self.rotation_to_world);
        let seen = |point: &KeypointReport| SeenPoint {
            name: point.name.clone(),
            world: to_world * DVec3::from_array(point.position_m) + DVec3::from_array(self.position_m),
            pixel: point.px.map(DVec2::from_array),
            is_visible: point.visible,
        };
        self.keypoints.iter().map(seen).collect()
    }
}

impl MaskReport {
    fn new(mask: &Mask, resolution: [u32; 2]) -> Self {
        let [width, height] = resolution;
        let mask_of = RunLengths { size: [height, width], counts: mask.column_runs(resolution) };
        Self { pixels: mask.count(), box_px: mask.bounds(), mask: mask_of }
    }
}
