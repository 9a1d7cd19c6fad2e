//! Rectified images of two cameras of a rig: a point appears in the same row of both.
//!
//! | file | holds |
//! |---|---|
//! | `CAMERA/NUMBER/image.png` and the like | the images of each camera |
//! | `CAMERA/NUMBER/truth.exr` | depth along the rectified axis and disparity, where the data set has depth |
//! | `stereo.yaml` | both cameras as the rectified images show them, in OpenCV's words |
//! | `rectify.json` | what was done: a [`RectifiedReport`] |
//! | `epipolar/NUMBER-original.png`, `epipolar/NUMBER-rectified.png` | both images with epipolar lines, on request |

use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::epipolar_lines::{EpipolarLines, Shown};
use super::layout_folder::{LayoutFolder, TRUTH, check_size};
use super::read_dataset::read_dataset;
use super::rectified_truth::rectified_truth;
use super::selection::FrameList;
use photosite_calibration::camera_files::{DisparityScale, RectifiedView, StereoPair, opencv_pair};
use photosite_calibration::layouts::{ImageSet, LayoutFiles, Shot};
use photosite_capture::report::matrix::rows;
use photosite_core::image::Planes;
use photosite_core::input;
use photosite_core::output::write_unsynced;
use photosite_core::{Error, Invalid, Result, Sandbox};
use photosite_develop::{ResizeFilter, remap};
use photosite_files::exr::{Attribute, ExrImage, Values, read_exr, write_exr, write_exr_of};
use photosite_files::formats::PNG;
use photosite_files::plain_image::{PlainImage, write_plain_image};
use photosite_files::pretty_json::pretty_json;
use photosite_measure::synthetic_noise::round_to_codes;

/// Name of the report of a rectification.
const REPORT: &str = "rectify.json";
/// Images that may be beside image.png.
const OTHER_IMAGES: [&str; 3] = ["ideal.png", "ideal.exr", "hdr.exr"];

/// Settings of rectifying a data set.
#[derive(Clone, Debug)]
pub struct RectifySettings {
    /// Names of the cameras, the reference first; `None` for the two that there are.
    pub pair: Option<[String; 2]>,
    /// Frames to rectify; `None` for all.
    pub frames: Option<FrameList>,
    /// Interpolation between pixels.
    pub filter: ResizeFilter,
    /// Number of epipolar lines, drawn over images of their own; 0 draws none.
    pub lines: u32,
}

/// Report of a rectified data set.
#[derive(Clone, Debug, Serialize)]
pub struct RectifiedReport {
    photosite_version: &'static str,
    /// Folder of the data set.
    pub dataset: String,
    /// Names of the reference and of the other camera.
    pub cameras: [String; 2],
    /// Numbers of the rectified frames.
    pub frames: Vec<u32>,
    /// Columns and rows of the rectified images.
    pub resolution_px: [u32; 2],
    /// Interpolation between pixels.
    pub interpolation: ResizeFilter,
    /// Focal length f of both rectified images.
    pub focal_length_px: f64,
    /// Principal point c of both rectified images, the centre of the first pixel at 0, 0.
    pub principal_point_px: [f64; 2],
    /// Baseline b: distance of the second camera to the right of the first, or below it, m.
    pub baseline_m: f64,
    /// Whether the cameras stand one above the other, so that columns correspond instead of rows.
    pub is_vertical: bool,
    /// Rotations R₁ and R₂, row by row, from the coordinates of each camera to the rectified ones.
    pub rotations: [[[f64; 3]; 3]; 2],
    /// Rectangles of pixels that are all within each camera's image: column, row, width, height.
    pub valid_region_px: [Option<[u32; 4]>; 2],
    /// Fraction of the pixels of each image that its camera sees; the others are black.
    pub valid_part: [f64; 2],
    /// Whether there is ground truth of depth and disparity.
    pub truth: bool,
    /// Warnings about the images.
    pub warnings: Vec<String>,
}

/// Scale of disparities in a report.
#[derive(Deserialize)]
struct Scale {
    focal_length_px: f64,
    baseline_m: f64,
}

/// Conversion from disparity to depth for a folder that [`rectify`] has filled.
pub fn disparity_scale(folder: &Path) -> Result<DisparityScale> {
    let path = folder.join(REPORT);
    let text = input::read_text(&path, input::TREE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
    let damaged = |why: String| Invalid::new("", format!("is damaged: {why}")).in_file(&path);
    let scale: Scale = serde_json::from_str(&text).map_err(|error| damaged(error.to_string()))?;
    DisparityScale::new(scale.focal_length_px, scale.baseline_m, 0.0).map_err(|invalid| invalid.in_file(&path))
}

/// Makes a new folder of the rectified images of a finished data set.
pub fn rectify(
    sandbox: &Sandbox,
    dataset: &Path,
    output: &Path,
    settings: &RectifySettings,
) -> Result<RectifiedReport> {
    LayoutFolder::check(output)?;
    let mut set = read_dataset(dataset)?;
    let cameras = chosen_pair(&set, settings.pair.as_ref())?;
    let mut warnings = Vec::new();
    warnings.extend(keep_frames(&mut set, settings.frames.as_ref())?);
    let of_set = |invalid: Invalid| invalid.in_file(dataset);
    let help = "choose frames that share one rig, or make a data set that varies neither lenses nor their places on it";
    let rig = set.rig().map_err(|invalid| of_set(invalid.help(help)))?;
    let pair = StereoPair::new(&rig[cameras[0]], &rig[cameras[1]]).map_err(of_set)?;
    let views = pair.views();
    let valid_part = views.map(|view| valid_part(&view, pair.resolution()));
    if set.shots.iter().any(|shot| shot.is_skewed && cameras.contains(&shot.camera)) {
        warnings.push(
            "rows are exposed one after another while something moves: the images are rectified as if they were taken at once"
                .to_owned(),
        );
    }
    let mut folder = LayoutFolder::begin(sandbox, output, dataset)?;
    let [left, right] = views.map(|view| view.rectified_camera());
    let rectified = StereoPair::new(&left, &right).map_err(of_set)?;
    folder.write_text("stereo.yaml", &opencv_pair(&rectified).map_err(of_set)?)?;
    let lines = (settings.lines > 0).then(|| EpipolarLines::new(&pair, settings.lines));
    let mut frames: Vec<u32> = set.shots.iter().map(|shot| shot.frame).collect();
    frames.dedup();
    let mut has_truth = true;
    for &frame in &frames {
        let mut seen = Vec::new();
        for (&camera, view) in cameras.iter().zip(&views) {
            let Some(shot) = set.of_camera(camera).find(|shot| shot.frame == frame) else { continue };
            let work = Work { shot, view, size: pair.resolution().map(|n| n as usize), filter: settings.filter };
            seen.push(work.images(&folder, &mut warnings)?);
            has_truth &= work.truth(&folder, pair.disparity_scale())?;
        }
        if let (Some(lines), [left, right]) = (&lines, &seen[..]) {
            let place = |kind: &str| folder.place(&format!("epipolar/{frame:06}-{kind}.png"));
            write_unsynced(&place("original")?, |to| lines.write_original([left.original(), right.original()], to))?;
            let rectified = [left.rectified(), right.rectified()];
            write_unsynced(&place("rectified")?, |to| lines.write_rectified(rectified, to))?;
        }
    }
    let report = RectifiedReport {
        photosite_version: env!("CARGO_PKG_VERSION"),
        dataset: dataset.display().to_string(),
        cameras: pair.cameras.map(|camera| camera.name.clone()),
        frames,
        resolution_px: pair.resolution(),
        interpolation: settings.filter,
        focal_length_px: pair.focal_length_px,
        principal_point_px: pair.centre_px.to_array(),
        baseline_m: pair.baseline_m(),
        is_vertical: pair.is_vertical,
        rotations: pair.rotations.map(rows),
        valid_region_px: views.map(|view| view.valid_region_px()),
        valid_part,
        truth: has_truth,
        warnings,
    };
    folder.write_text(REPORT, &(pretty_json(&report) + "\n"))?;
    folder.finish(output)?;
    Ok(report)
}

/// Indices of the cameras.
fn chosen_pair(set: &ImageSet, wanted: Option<&[String; 2]>) -> Result<[usize; 2]> {
    let names = set.cameras.join(", ");
    let refused = |message: String, help: String| Err(Error::Usage { message, help: Some(help.into()) });
    let Some(wanted) = wanted else {
        return match set.cameras.len() {
            2 => Ok([0, 1]),
            1 => refused(
                format!("{} has one camera, {names}, and rectification needs two", set.folder.display()),
                "make the data set with two [[cameras]]".to_owned(),
            ),
            _ => refused(
                format!("{} has the cameras {names}", set.folder.display()),
                format!("choose two of them with --pair {},{}", set.cameras[0], set.cameras[1]),
            ),
        };
    };
    if wanted[0] == wanted[1] {
        return refused(format!("--pair names {} twice", wanted[0]), format!("name two cameras of {names}"));
    }
    let mut found = [0; 2];
    for (index, name) in found.iter_mut().zip(wanted) {
        let Some(camera) = set.cameras.iter().position(|camera| camera == name) else {
            let message = format!("{} has no camera {name}", set.folder.display());
            return refused(message, format!("it has {names}"));
        };
        *index = camera;
    }
    Ok(found)
}

/// Keeps the selected frames, and warns of those that do not exist.
fn keep_frames(set: &mut ImageSet, frames: Option<&FrameList>) -> Result<Option<String>> {
    let Some(list) = frames else { return Ok(None) };
    let count = set.shots.iter().map(|shot| shot.frame + 1).max().unwrap_or(0);
    let (numbers, is_more) = list.among(count);
    if numbers.is_empty() {
        let message = format!("--frames {list} names none of the frames 0..{count}");
        return Err(Error::Usage { message, help: Some("name frames that exist".into()) });
    }
    set.shots.retain(|shot| numbers.contains(&shot.frame));
    Ok(is_more.then(|| format!("--frames names frames that do not exist: the data set has {count}, 0..{count}")))
}

fn valid_part(view: &RectifiedView<'_>, [width, height]: [u32; 2]) -> f64 {
    let centre = |x: u32, y: u32| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let seen = (0..height).flat_map(|y| (0..width).map(move |x| centre(x, y)));
    let count = seen.filter(|position| view.source_px(*position).is_some()).count();
    count as f64 / (f64::from(width) * f64::from(height))
}

/// Image of a camera that is to be rectified.
struct Work<'a> {
    shot: &'a Shot,
    view: &'a RectifiedView<'a>,
    size: [usize; 2],
    filter: ResizeFilter,
}

/// Pixel values of image.png before and after rectification.
struct Both {
    file: PlainImage,
    rectified: Planes,
}

impl Both {
    fn shown<'a>(&self, planes: &'a Planes) -> Shown<'a> {
        Shown { planes, full_scale: self.file.largest.unwrap_or(u16::MAX).into() }
    }

    fn original(&self) -> Shown<'_> {
        self.shown(&self.file.planes)
    }

    fn rectified(&self) -> Shown<'_> {
        self.shown(&self.rectified)
    }
}

impl Work<'_> {
    /// Writes the rectified images; warnings say what their files state and the new ones do not.
    fn images(&self, folder: &LayoutFolder, warnings: &mut Vec<String>) -> Result<Both> {
        let image = self.coded(folder, &folder.image(self.shot)?, "image.png", warnings)?;
        for name in OTHER_IMAGES {
            let path = folder.of_shot(self.shot, name);
            if !path.is_file() {
                continue;
            }
            if name.ends_with(".exr") {
                self.linear(folder, &path, name)?;
            } else {
                self.coded(folder, &path, name, warnings)?;
            }
        }
        Ok(image)
    }

    fn coded(&self, folder: &LayoutFolder, path: &Path, name: &str, warnings: &mut Vec<String>) -> Result<Both> {
        let (file, left_out) = PlainImage::read(path)?;
        warnings.extend(left_out);
        warnings.extend(file.colours.lost_in(&PNG, path));
        let rectified = self.remap(&file.planes, path)?;
        // Both cameras of a rectified pair have one focal length: pixels are square.
        let mut rounded = PlainImage { planes: rectified.clone(), pixel_aspect: 1.0, ..file.clone() };
        round_to_codes(&mut rounded.planes, file.largest.unwrap_or(u16::MAX).into());
        write_unsynced(&self.place(folder, name)?, |to| write_plain_image(&rounded, &PNG, to))?;
        Ok(Both { file, rectified })
    }

    fn linear(&self, folder: &LayoutFolder, path: &Path, name: &str) -> Result<()> {
        let ExrImage { planes, attributes, .. } = read(path)?;
        let rectified = self.remap(&planes, path)?;
        let square = |value: &Attribute| {
            if let Attribute::PixelAspect(_) = value { Attribute::PixelAspect(1.0) } else { value.clone() }
        };
        let attributes: Vec<(&str, Attribute)> =
            attributes.iter().map(|(key, value)| (&key[..], square(value))).collect();
        write_unsynced(&self.place(folder, name)?, |to| write_exr(&rectified, &attributes, to))
    }

    fn remap(&self, planes: &Planes, path: &Path) -> Result<Planes> {
        check_size([planes.width(), planes.height()].map(|n| n as u32), self.shot, path)?;
        Ok(remap(planes, self.size, self.filter, |position| self.view.source_px(position)))
    }

    /// Writes depth and disparity; returns whether there is any.
    fn truth(&self, folder: &LayoutFolder, scale: DisparityScale) -> Result<bool> {
        let path = folder.of_shot(self.shot, TRUTH);
        if !path.is_file() {
            return Ok(false);
        }
        let truth = read(&path)?.planes;
        check_size([truth.width(), truth.height()].map(|n| n as u32), self.shot, &path)?;
        let camera = &self.shot.calibrated;
        let Some(rectified) = rectified_truth(&truth, camera, self.view, scale, self.size) else { return Ok(false) };
        let attributes = [("unit", Attribute::Text("depth: m; disparity: px".to_owned()))];
        write_unsynced(&self.place(folder, TRUTH)?, |to| write_exr_of(Values::Smooth, &rectified, &attributes, to))?;
        Ok(true)
    }

    fn place(&self, folder: &LayoutFolder, name: &str) -> Result<PathBuf> {
        folder.place(&format!("{}/{name}", self.shot.folder))
    }
}

fn read(path: &Path) -> Result<ExrImage> {
    let file = input::open(path).map_err(|reason| Error::io(path, "read", reason))?;
    read_exr(BufReader::new(file)).and_then(ExrImage::whole).map_err(|invalid| invalid.in_file(path))
}
