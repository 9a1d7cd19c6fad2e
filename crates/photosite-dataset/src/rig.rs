//! Cameras of a data set with their captures, before anything is varied, and checks of these.

use std::path::Path;

use glam::{DAffine3, DVec2};

use super::varied;
use photosite_calibration::dataset::{Found, Plan, RigCamera, Subject};
use photosite_calibration::targets::PlacedTarget;
use photosite_calibration::truth::{Needs, TruthLayer};
use photosite_capture::{Capture, DatasetFile};
use photosite_core::{Invalid, Result, Sandbox};
use photosite_pipeline::standalone_camera;
use photosite_sensor::{SensorModel, Use};
use photosite_transport::optics::LensKind;

/// Plans the frames; returns the plan, the capture of each camera before anything is varied, and the matches of the
/// variations' patterns.
pub(super) fn plan(
    file: &DatasetFile,
    sandbox: &Sandbox,
    capture_path: &Path,
    overrides: &[String],
) -> Result<(Plan, Vec<Capture>, Vec<Found>)> {
    let description = &file.description;
    let rig = description.rig().map_err(|invalid| file.error(invalid))?;
    let mut cameras = Vec::new();
    let mut captures: Vec<Capture> = Vec::new();
    for mut place in rig {
        let set: Vec<String> = place.set.iter().chain(overrides).cloned().collect();
        let read = || {
            let capture = match captures.first() {
                None => Capture::load_for_set(sandbox, capture_path, &set)?,
                // The scene is read once.
                Some(first) => first.with_all(&set)?,
            };
            check(&capture)?;
            if description.zooms() && capture.lens().intrinsics.is_some() {
                let message = "states the camera matrix, which a focal length of poses.trajectory would not change";
                let invalid =
                    Invalid::new("lens.intrinsics", message).help("remove it, or the focal lengths of the poses");
                return Err(capture.source().error(invalid));
            }
            let camera = standalone_camera(&capture)?;
            Ok((camera, capture))
        };
        let read = read().map_err(|error| file.error_of_change(error, &place.name, None, &place.set));
        let (camera, capture) = read?;
        // Of a rig, the calibration says where in it the camera stands.
        if let Some(stated) = description.cameras.get(captures.len()).filter(|_| capture.is_placed_by_calibration()) {
            if stated.position_m.is_some() || stated.look_at_m.is_some() || stated.up.is_some() {
                let message = "cannot be combined with camera.calibration_pose, which says where in the rig it stands";
                let invalid = Invalid::new(format!("cameras[{}]", captures.len()), message);
                return Err(file.error(invalid.help("remove position_m, look_at_m and up, or calibration_pose")));
            }
            place.in_rig = capture.camera_to_world();
        }
        // Cameras of a rig of which nothing else is stated have serial numbers of their own.
        let serial = capture.sensor().serial.saturating_add(if place.is_numbered { 0 } else { captures.len() as u64 });
        let seed = capture.render().seed;
        // A variation may ask for flow in some frames.
        let varies_truth = description.vary.iter().any(|d| d.keys().any(|key| key.starts_with("output")));
        let flows = varies_truth || TruthLayer::any_needs(&capture.output().truth.layers, Needs::NextImage);
        cameras.push(RigCamera { place, camera, serial, seed, flows, scene_moves: capture.scene_moves() });
        captures.push(capture);
    }
    let is_calibrated = |captures: &[Capture]| {
        !description.cameras.is_empty() && captures.iter().any(Capture::is_placed_by_calibration)
    };
    if is_calibrated(&captures) {
        for (index, capture) in captures.iter_mut().enumerate() {
            let Some(partner) = cameras[index].place.partner else { continue };
            let partner_in_rig = cameras[partner].place.in_rig;
            let place = &mut cameras[index].place;
            place.set_partner(&partner_in_rig);
            let set: Vec<String> = place.set.iter().chain(overrides).cloned().collect();
            *capture = capture.with_all(&set)?;
        }
    }
    for (index, camera) in cameras.iter().enumerate() {
        if let Some(other) = cameras[..index].iter().find(|other| other.serial == camera.serial) {
            let (name, number) = (&other.place.name, camera.serial);
            let message = format!("has the serial number {number} of {name}, and so the same fixed pattern");
            let invalid = Invalid::new(format!("cameras[{index}]"), message);
            return Err(file.error(invalid.help("give each a sensor.serial of its own in its `set`")));
        }
    }
    for (index, camera) in cameras.iter().enumerate() {
        let Some(partner) = camera.place.partner else { continue };
        let (own, other) = (&captures[index], &captures[partner]);
        let geometry = |sensor: &SensorModel| (sensor.resolution, sensor.pixel_pitch_m, sensor.shutter);
        if own.lens() != other.lens() || geometry(own.sensor()) != geometry(other.sensor()) {
            let message = "disparity needs two cameras of one kind, and lens or sensor of the other differ";
            let key = format!("cameras[{index}].disparity_to");
            return Err(file.error(Invalid::new(key, message).help("remove it, or give both the same `set`")));
        }
    }
    let subjects = subjects(&captures[0]);
    // The frame of a calibration is that of the rig.
    let start = if is_calibrated(&captures) { DAffine3::IDENTITY } else { captures[0].camera_to_world() };
    let found = varied::find(file, sandbox, &captures[0])?;
    let plan = Plan::new(description, cameras, &subjects, start, &found).map_err(|invalid| file.error(invalid))?;
    Ok((plan, captures, found))
}

/// Targets that poses can be taken around, with all corners of the sheet.
fn subjects(capture: &Capture) -> Vec<Subject> {
    let of_target = |target: &PlacedTarget| {
        let [low, high] = target.target.sheet;
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let points = corners.map(|corner| target.world(corner)).to_vec();
        Subject { name: target.name.clone(), to_world: target.to_world, points }
    };
    capture.targets().iter().map(of_target).collect()
}

/// Refuses settings of a capture that a data set cannot have.
fn check(capture: &Capture) -> Result<()> {
    let refuse =
        |key: &str, message: &str, help: &str| Err(capture.source().error(Invalid::new(key, message).help(help)));
    if capture.exposure().frames != 1 {
        return refuse("exposure.frames", "a data set makes its own series", "remove it");
    }
    capture.sensor().allows(Use::DataSet).map_err(|invalid| capture.source().error(invalid))?;
    if capture.lens().kind == LensKind::Bare {
        let message = "the images of a data set have a camera, and a bare sensor has none";
        return refuse("lens.type", message, "render captures of bare sensors one by one");
    }
    if capture.render().time_limit_s.is_some() {
        let help = "write samples_per_pixel or noise_target";
        return refuse("render.time_limit_s", "would make another data set each time", help);
    }
    Ok(())
}
