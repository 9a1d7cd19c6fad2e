//! Overlays of a data set's image: corners of targets, boxes and masks of objects, epipolar lines of its rig. All
//! positions are pixels from the upper left corner of the image, with integers at the edges of pixels.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec2;
use serde::Serialize;

use super::epipolar_lines::original_curves;
use super::layout_folder::{OBJECTS, TRUTH};
use super::read_dataset::{Line, refuse_resampled, shot};
use super::sheet::Sheet;
use photosite_calibration::camera_files::StereoPair;
use photosite_calibration::layouts::{SceneObject, SeenPoint, SeenTarget, Shot};
use photosite_capture::report::{ObjectReport, ObjectsReport, REPORT, Report, RunLengths};
use photosite_core::input;
use photosite_core::{Error, Invalid, Result};
use photosite_files::exr::read_exr_file;

/// Number of epipolar lines over an image.
const LINES: u32 = 12;

/// Overlays of an image.
#[derive(Clone, Debug, Serialize)]
pub struct Overlays {
    /// Columns and rows of the camera.
    pub size_px: [u32; 2],
    /// Points of calibration targets.
    pub corners: Vec<Corner>,
    /// Objects with ground truth.
    pub objects: Vec<SeenObject>,
    /// Epipolar lines that this image shares with that of another camera.
    pub epipolar: Option<Epipolar>,
    /// Reasons why something is not drawn.
    pub notes: Vec<String>,
}

/// Point of a calibration target.
#[derive(Clone, Debug, Serialize)]
pub struct Corner {
    /// Name of the target, and of the point on it.
    pub name: [String; 2],
    /// Position in the image.
    pub px: [f64; 2],
    /// Whether the point is within the image and not occluded.
    pub is_visible: bool,
}

/// Object that the image sees.
#[derive(Clone, Debug, Serialize)]
pub struct SeenObject {
    /// Name of the object.
    pub name: String,
    /// Category of the object.
    pub category: Option<String>,
    /// Bounding box of the pixels that see the object: left, top, width, height.
    pub box_px: [u32; 4],
    /// Box that the object would have without occluders, where known.
    pub amodal_box_px: Option<[u32; 4]>,
    /// Projections of the corners of the object's box in space; empty where unknown.
    pub corners_px: Vec<Option<[f64; 2]>>,
    /// Pixels that see the object.
    pub mask: RunLengths,
}

/// Epipolar lines: equal indices mean the same plane through both cameras.
#[derive(Clone, Debug, Serialize)]
pub struct Epipolar {
    /// Name of the other camera.
    pub partner: String,
    /// Lines, each in the pieces that the camera sees; through a lens with distortion they are curves.
    pub lines: Vec<Vec<Vec<[f64; 2]>>>,
}

impl Overlays {
    /// Reads the overlays of image `number` of a sheet.
    ///
    /// # Errors
    ///
    /// A report, or a file of ground truth, that is damaged; an image that was developed without the distortion that
    /// ground truth has.
    pub fn read(sheet: &Sheet, number: usize) -> Result<Option<Self>> {
        let Some((folder, shot)) = shot_of(sheet, number)? else { return Ok(None) };
        refuse_resampled(&folder, &shot)?;
        let mut notes = Vec::new();
        let objects = objects(&folder, &shot)?.unwrap_or_else(|| {
            notes.push(
                "no objects: the data set was made without output.objects, and without the truth \"instance\""
                    .to_owned(),
            );
            Vec::new()
        });
        let corners: Vec<Corner> = corners(&shot).collect();
        if corners.is_empty() {
            notes.push("no corners: the capture has no calibration target".to_owned());
        }
        let epipolar = match sheet.partner_of(number) {
            None => {
                notes.push("no epipolar lines: this frame has no image of another camera".to_owned());
                None
            }
            Some(partner) => match epipolar(sheet, &shot, partner)? {
                Ok(lines) => Some(lines),
                Err(invalid) => {
                    notes.push(format!("no epipolar lines: {}", invalid.message));
                    None
                }
            },
        };
        if shot.is_skewed {
            notes.push(
                "rows are exposed one after another: epipolar lines are those of the middle of the exposure".to_owned(),
            );
        }
        Ok(Some(Self { size_px: shot.calibrated.resolution, corners, objects, epipolar, notes }))
    }
}

/// Folder of an image, and its report.
fn shot_of(sheet: &Sheet, number: usize) -> Result<Option<(std::path::PathBuf, Shot)>> {
    let (Some(folder), Some(image)) = (sheet.folder_of(number), sheet.images.get(number)) else { return Ok(None) };
    let path = folder.join(REPORT);
    let line = Line {
        frame: image.frame,
        frames: sheet.frames,
        camera: image.camera.clone(),
        time_s: image.time_s,
        folder: String::new(),
        sums: BTreeMap::new(),
    };
    let camera = sheet.cameras.iter().position(|name| *name == image.camera).unwrap_or(0);
    let shot = shot(&path, Report::read(&path)?, line, camera)?;
    Ok(Some((folder, shot)))
}

fn corners(shot: &Shot) -> impl Iterator<Item = Corner> {
    let of_target = |target: &'_ SeenTarget| -> Vec<Corner> {
        let corner = |point: &SeenPoint| {
            let px = (point.pixel? + 0.5).to_array();
            Some(Corner { name: [target.name.clone(), point.name.clone()], px, is_visible: point.is_visible })
        };
        target.points.iter().filter_map(corner).collect()
    };
    shot.targets.iter().flat_map(of_target)
}

/// Objects that the image sees; `None` where these were not requested.
fn objects(folder: &Path, shot: &Shot) -> Result<Option<Vec<SeenObject>>> {
    let path = folder.join(OBJECTS);
    if path.is_file() {
        let text = input::read_text(&path, input::TABLE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
        let read: std::result::Result<ObjectsReport, _> = serde_json::from_str(&text);
        let report = read.map_err(|error| Invalid::new("", format!("is damaged: {error}")).in_file(&path))?;
        return Ok(Some(report.objects.into_iter().filter_map(reported).collect()));
    }
    let path = folder.join(TRUTH);
    if !path.is_file() {
        return Ok(None);
    }
    let truth = read_exr_file(&path)?.whole().map_err(|invalid| invalid.in_file(&path))?.planes;
    Ok(truth.plane("instance").map(|plane| of_numbers(plane, [truth.width(), truth.height()], &shot.objects)))
}

fn reported(object: ObjectReport) -> Option<SeenObject> {
    let corner = |corner: Option<[f64; 2]>| corner.map(|[x, y]| [x + 0.5, y + 0.5]);
    Some(SeenObject {
        name: object.name,
        category: object.category,
        box_px: object.visible.box_px?,
        amodal_box_px: object.alone.box_px,
        corners_px: object.box_corners_px.map(corner).to_vec(),
        mask: object.visible.mask,
    })
}

/// Objects found by the instance numbers of the pixels that see them.
fn of_numbers(plane: &[f32], [width, height]: [usize; 2], objects: &[SceneObject]) -> Vec<SeenObject> {
    let seen = |object: &SceneObject| {
        let is_inside = |x: usize, y: usize| object.numbers.contains(&(plane[y * width + x] as u32));
        // Outside and inside in turns, down the columns.
        let (mut counts, mut inside) = (vec![0], false);
        let (mut low, mut high) = ([width, height], [0, 0]);
        for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
            if is_inside(x, y) != inside {
                inside = !inside;
                counts.push(0);
            }
            *counts.last_mut()? += 1;
            if inside {
                low = [low[0].min(x), low[1].min(y)];
                high = [high[0].max(x + 1), high[1].max(y + 1)];
            }
        }
        let box_px = [low[0], low[1], high[0].checked_sub(low[0])?, high[1].checked_sub(low[1])?].map(|n| n as u32);
        Some(SeenObject {
            name: object.name.clone(),
            category: object.category.clone(),
            box_px,
            amodal_box_px: None,
            corners_px: Vec::new(),
            mask: RunLengths { size: [height, width].map(|n| n as u32), counts },
        })
    };
    objects.iter().filter_map(seen).collect()
}

/// Epipolar lines of an image and that of another camera of the same frame. The first camera of a data set is the
/// reference, so that both have the same planes.
fn epipolar(sheet: &Sheet, shot: &Shot, partner: usize) -> Result<std::result::Result<Epipolar, Invalid>> {
    let Some((_, other)) = shot_of(sheet, partner)? else {
        return Ok(Err(Invalid::new("", "the other image is gone")));
    };
    let is_first = shot.camera < other.camera;
    let [first, second] = if is_first { [shot, &other] } else { [&other, shot] };
    Ok(StereoPair::new(&first.calibrated, &second.calibrated).map(|pair| {
        let curves = original_curves(&pair, usize::from(!is_first), LINES);
        let lines = curves.into_iter().map(pieces).collect();
        Epipolar { partner: other.calibrated.name.clone(), lines }
    }))
}

/// Pieces of a curve that the camera sees, with a point every few pixels.
fn pieces(curve: Vec<Option<DVec2>>) -> Vec<Vec<[f64; 2]>> {
    /// Distance between two points of a line, px: no lens bends a line much within that.
    const STEP_PX: f64 = 4.0;
    let mut pieces = Vec::new();
    for piece in curve.split(Option::is_none) {
        let points: Vec<DVec2> = piece.iter().copied().flatten().collect();
        let [first, .., last] = points[..] else { continue };
        let (mut kept, mut before) = (vec![first.to_array()], first);
        for &point in &points {
            if before.distance(point) >= STEP_PX {
                kept.push(point.to_array());
                before = point;
            }
        }
        kept.push(last.to_array());
        pieces.push(kept);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_of_numbers_are_those_of_coco() {
        // Columns: 0 0, 3 1, 3 3, 0 3.
        let plane = [0.0, 3.0, 3.0, 0.0, 0.0, 1.0, 3.0, 3.0];
        let object = |name: &str, numbers: &[u32]| SceneObject {
            name: name.to_owned(),
            category: None,
            to_world: glam::DAffine3::IDENTITY,
            numbers: numbers.to_vec(),
        };
        let objects = [object("one", &[1]), object("unseen", &[2]), object("three", &[3]), object("both", &[1, 3])];
        let found = of_numbers(&plane, [4, 2], &objects);
        let facts: Vec<_> = found.iter().map(|o| (o.name.as_str(), o.box_px, o.mask.counts.clone())).collect();
        assert_eq!(
            facts,
            [
                ("one", [1, 1, 1, 1], vec![3, 1, 4]),
                ("three", [1, 0, 3, 2], vec![2, 1, 1, 2, 1, 1]),
                ("both", [1, 0, 3, 2], vec![2, 4, 1, 1]),
            ]
        );
    }

    #[test]
    fn curves_are_cut_where_nothing_is_seen() {
        let at = |x: f64| Some(DVec2::new(x, 1.0));
        let curve = vec![None, at(0.0), at(1.0), at(4.5), at(5.0), None, None, at(9.0), None, at(20.0), at(21.0)];
        assert_eq!(pieces(curve), [vec![[0.0, 1.0], [4.5, 1.0], [5.0, 1.0]], vec![[20.0, 1.0], [21.0, 1.0]]]);
    }
}
