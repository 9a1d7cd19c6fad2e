//! Calibration of a camera, `lens.calibration`: matrix and lens from a file of another tool, and the pose from it,
//! `camera.calibration_pose`.
//!
//! The matrix is taken to the pixels of the whole sensor. Its focal length in pixels, times the pixel pitch, is the
//! distance of the image, from which the focal length follows.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec2};

use super::super::tables::spectra::Finder;
use super::super::tables::{CameraTable, LensTable};
use photosite_calibration::calibration_files::{Calibration, CalibrationFile, StatedPose};
use photosite_core::image_grid::ImageGrid;
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::warnings::Warnings;
use photosite_core::{Error, Invalid, input};
use photosite_sensor::SensorModel;
use photosite_transport::optics::{Intrinsics, Projection};

const KEY: &str = "calibration";
const CAMERA: &str = "calibration_camera";
const AREA: &str = "calibration_area_px";
const POSE: &str = "calibration_pose";
/// Focal lengths, and shapes of pixels, that differ by more than this are told: that of a lens by its name is rounded by
/// up to 5 %.
const ROUNDED: f64 = 0.05;

/// Calibration that a capture names, on the pixels of its sensor.
#[derive(Clone, Debug)]
pub(crate) struct Calibrated {
    pub(crate) intrinsics: Intrinsics,
    pub(crate) projection: Projection,
    /// Area of the sensor that the calibration's image shows, where it is not all of it: x, y, width and height, px.
    pub(crate) area_px: Option<[f64; 4]>,
    /// Camera → the frame of the pose that is asked for.
    pub(crate) pose: Option<DAffine3>,
    /// Files that were read besides the one that the capture names.
    pub(crate) files: Vec<PathBuf>,
}

impl Calibrated {
    /// Calibration of `[lens]`, with the pose of `[camera]`; `None` where there is none. `read_out` is the grid of the
    /// pixels that the sensor delivers.
    pub(crate) fn of(
        finder: &Finder<'_>,
        (camera, lens): (&CameraTable, &LensTable),
        sensor: &SensorModel,
        read_out: &ImageGrid,
        warnings: &mut Warnings,
    ) -> Result<Option<Self>, Invalid> {
        let in_lens = |invalid: Invalid| invalid.within("lens");
        let Some(name) = &lens.calibration else {
            return match (&lens.calibration_camera, lens.calibration_area_px, &camera.calibration_pose) {
                (Some(_), _, _) => Err(in_lens(without_file(CAMERA))),
                (None, Some(_), _) => Err(in_lens(without_file(AREA))),
                (None, None, Some(_)) => Err(without_file(POSE).within("camera")),
                (None, None, None) => Ok(None),
            };
        };
        refuse_others(lens).map_err(in_lens)?;
        let path = finder.path(name).map_err(|invalid| invalid.within(KEY)).map_err(in_lens)?;
        let mut file =
            CalibrationFile::parse(&read(&path).map_err(in_lens)?, &path).map_err(of_file).map_err(in_lens)?;
        let mut files = Vec::new();
        if let (Some(_), Some(poses)) = (&camera.calibration_pose, file.file_of_poses(&path)) {
            file.add_poses(&read(&poses).map_err(in_lens)?, &poses).map_err(of_file).map_err(in_lens)?;
            files.push(poses);
        }
        let chosen = choose(&file.cameras, lens.calibration_camera.as_deref(), camera.calibration_pose.as_deref());
        let chosen = chosen.map_err(in_lens)?;
        let pose = camera.calibration_pose.as_deref().map(|name| pose(chosen, name)).transpose();
        let pose = pose.map_err(|invalid| invalid.within("camera"))?;
        let shown = format!("lens.calibration {name}");
        for words in &chosen.warnings {
            warnings.once(format!("{shown}: {words}"));
        }
        let area_px = match lens.calibration_area_px {
            Some(area) => {
                if chosen.resolution.is_none() {
                    warnings.once(format!("{shown}: does not say of how many pixels it is; taken for those of {AREA}"));
                }
                Some(checked_area(area, sensor).map_err(in_lens)?)
            }
            None => shown_area(chosen, &shown, sensor, read_out, warnings).map_err(in_lens)?,
        };
        let intrinsics = on_sensor(chosen, area_px);
        warn_of_contradictions(&intrinsics, &shown, lens, sensor, warnings);
        Ok(Some(Self { intrinsics, projection: chosen.projection, area_px, pose, files }))
    }
}

fn without_file(key: &str) -> Invalid {
    Invalid::new(key, "needs lens.calibration").help("write [lens] calibration = \"camchain.yaml\", or remove it")
}

/// Refuses keys that say in another way what a calibration does.
fn refuse_others(lens: &LensTable) -> Result<(), Invalid> {
    for (key, is_given) in [
        ("prescription", lens.prescription.is_some()),
        ("intrinsics", lens.intrinsics.is_some()),
        ("projection", lens.projection.is_some()),
        ("xi", lens.xi.is_some()),
        ("distortion", lens.distortion.is_some()),
        ("lensmaker", lens.lensmaker.is_some()),
        ("horizontal_fov_deg", lens.horizontal_fov_deg.is_some()),
    ] {
        if is_given {
            let message = "cannot be combined with calibration, which says where light lands in the image";
            return Err(Invalid::new(key, message).help(format!("keep one of them: remove {key}, or calibration")));
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<String, Invalid> {
    input::read_text(path, input::TREE_BYTES).map_err(|source| {
        Invalid::new(KEY, format!("cannot read {}: {source}", path.display()))
            .help("paths are relative to the file that contains them")
    })
}

/// Error of a calibration file, at the key that names it.
fn of_file(error: Error) -> Invalid {
    let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
    let invalid = Invalid::new(KEY, error.to_string());
    match help {
        Some(help) => invalid.help(help),
        None => invalid,
    }
}

/// Camera of that name, else the only one, or the one that has the pose.
fn choose<'c>(cameras: &'c [Calibration], name: Option<&str>, pose: Option<&str>) -> Result<&'c Calibration, Invalid> {
    let names = || cameras.iter().map(|camera| camera.name.as_str());
    let with_pose = |camera: &&Calibration| camera.poses.iter().any(|known| Some(known.name.as_str()) == pose);
    match (name, cameras) {
        (Some(name), _) => cameras.iter().find(|camera| camera.name == name).ok_or_else(|| {
            Invalid::new(CAMERA, format!("the calibration has no camera {name:?}{}", did_you_mean(name, names())))
                .help(format!("it has {}", list(name, names())))
        }),
        (None, [only]) => Ok(only),
        (None, _) => {
            let mut of_pose = cameras.iter().filter(with_pose);
            match (of_pose.next(), of_pose.next()) {
                (Some(only), None) => Ok(only),
                _ => {
                    let message = format!("is missing, and the calibration has {} cameras", cameras.len());
                    let help = format!("write {CAMERA} = {:?}; it has {}", cameras[0].name, list("", names()));
                    Err(Invalid::new(CAMERA, message).help(help))
                }
            }
        }
    }
}

fn pose(camera: &Calibration, name: &str) -> Result<DAffine3, Invalid> {
    let mut of_name = camera.poses.iter().filter(|pose| pose.name == name);
    if let Some(StatedPose { to_frame, .. }) = of_name.next() {
        return match of_name.next() {
            None => Ok(*to_frame),
            Some(_) => Err(Invalid::new(POSE, format!("the calibration has two images {name:?}"))),
        };
    }
    let names = || camera.poses.iter().map(|pose| pose.name.as_str());
    let message = format!("the calibration has no pose {name:?} of {}{}", camera.name, did_you_mean(name, names()));
    let help = if camera.poses.is_empty() {
        "it has no poses of this camera; write position_m and look_at_m instead".to_owned()
    } else {
        format!("it has {}", list(name, names()))
    };
    Err(Invalid::new(POSE, message).help(help))
}

/// Area of a sensor that a capture states for its calibration.
fn checked_area(area: [f64; 4], sensor: &SensorModel) -> Result<[f64; 4], Invalid> {
    let [x, y, width, height] = area;
    let [columns, rows] = sensor.resolution.map(|n| n as f64);
    if width > 0.0 && height > 0.0 && x >= 0.0 && y >= 0.0 && x + width <= columns && y + height <= rows {
        return Ok(area);
    }
    let message = format!("must lie on the sensor's {columns} × {rows} pixels, got {area:?}");
    Err(Invalid::new(AREA, message).help(format!("all of them are [0, 0, {columns}, {rows}]")))
}

/// Area of the sensor that the image of a calibration shows by its number of pixels: what region and binning leave, or
/// `None` for all of the sensor, at its own scale or another.
fn shown_area(
    camera: &Calibration,
    shown: &str,
    sensor: &SensorModel,
    read_out: &ImageGrid,
    warnings: &mut Warnings,
) -> Result<Option<[f64; 4]>, Invalid> {
    let whole = sensor.resolution.map(|n| n as u32);
    let Some(size) = camera.resolution else {
        warnings.once(format!("{shown}: does not say of how many pixels it is; taken for all of the sensor's"));
        return Ok(None);
    };
    if size == whole {
        return Ok(None);
    }
    let [width, height] = whole;
    if size == read_out.resolution {
        let extent = read_out.per_pixel * DVec2::from(size.map(f64::from));
        return Ok(Some([read_out.first.x, read_out.first.y, extent.x, extent.y]));
    }
    let [of_width, of_height] = [0, 1].map(|axis| f64::from(size[axis]) / f64::from(whole[axis]));
    if of_width == of_height {
        warnings.once(format!(
            "{shown}: is of {} × {} pixels, and the sensor has {width} × {height}; it is taken to them, as if the image \
             had been resized",
            size[0], size[1],
        ));
        return Ok(Some([0.0, 0.0, f64::from(width), f64::from(height)]));
    }
    let message =
        format!("is of {} × {} pixels, and the sensor has {width} × {height}, of another shape", size[0], size[1]);
    let [w, h] = size;
    Err(Invalid::new(KEY, message).help(format!(
        "write [sensor] resolution_px = [{w}, {h}] with its pixel_pitch_um, [exposure] region_px = [x, y, {w}, {h}], or \
         [lens] {AREA} = [x, y, width, height], the area of the sensor that it is of"
    )))
}

/// Camera matrix on the pixels of the whole sensor, of a calibration whose image shows an area of it.
fn on_sensor(camera: &Calibration, area_px: Option<[f64; 4]>) -> Intrinsics {
    let Some([x, y, width, height]) = area_px else { return camera.intrinsics };
    // Pixels of the calibration per pixel of the sensor; without a number of its own the calibration has the area's.
    let [across, down] = camera.resolution.map_or([1.0; 2], |[w, h]| [f64::from(w) / width, f64::from(h) / height]);
    camera.intrinsics.on_grid([-x * across, -y * down], [across, down])
}

/// Warns of what contradicts sensor or lens: pixels of another shape, another focal length.
fn warn_of_contradictions(
    intrinsics: &Intrinsics,
    shown: &str,
    lens: &LensTable,
    sensor: &SensorModel,
    warnings: &mut Warnings,
) {
    let differ = |a: f64, b: f64| (a / b - 1.0).abs() > ROUNDED;
    let [x_mm, y_mm] = [intrinsics.fx * sensor.pixel_pitch_m[0] * 1e3, intrinsics.fy * sensor.pixel_pitch_m[1] * 1e3];
    if differ(x_mm, y_mm) {
        warnings.once(format!(
            "{shown}: fx = {:.6} px and fy = {:.6} px are {x_mm:.4} mm and {y_mm:.4} mm at the sensor's pixel pitch, which \
             should be one length; check sensor.pixel_pitch_um",
            intrinsics.fx, intrinsics.fy,
        ));
    }
    if let Some(stated_mm) = lens.focal_length_mm
        && differ(stated_mm, y_mm)
    {
        warnings.once(format!(
            "lens.focal_length_mm is {stated_mm}, but {shown} has fy = {:.6} px, {y_mm:.4} mm at the sensor's pixel pitch: \
             what is where in the image follows the calibration, and its blur focal_length_mm; remove it, or check \
             sensor.pixel_pitch_um",
            intrinsics.fy,
        ));
    }
}
