//! Pose of the camera, `[camera]`, and with the lens its field of view.

use glam::DAffine3;

use super::super::tables::spectra::Finder;
use super::super::tables::{CameraTable, CaptureFile, FocusDistance, LensTable};
use super::calibration::Calibrated;
use super::focus::ON_SCENE;
use super::framing::{Framing, LensSize, Sphere, bounding_sphere};
use super::lens::{DEFAULT_FOCAL_LENGTH_M, describe_lens, image_distance_of_field};
use super::prescription::Prescribed;
use photosite_core::Invalid;
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::warnings::Warnings;
use photosite_sensor::SensorModel;
use photosite_transport::geometry::Trajectory;
use photosite_transport::optics::{Focus, LensDescription};
use photosite_transport::scene::description::{CameraDescription, SceneDescription, looking};

/// Places the camera of `[camera]` and describes `[lens]`: camera → world, and the lens.
pub(crate) fn place_camera(
    CaptureFile { camera, lens, .. }: &CaptureFile,
    motion: Option<&Trajectory>,
    finder: &Finder<'_>,
    scene: &SceneDescription,
    (sensor, calibrated): (&SensorModel, Option<&Calibrated>),
    warnings: &mut Warnings,
) -> Result<(DAffine3, LensDescription), Invalid> {
    let of_calibration = calibrated.and_then(|calibrated| calibrated.pose);
    if of_calibration.is_some() {
        refuse_other_poses(camera, motion.is_some_and(Trajectory::is_absolute))
            .map_err(|invalid| invalid.within("camera"))?;
    }
    let pose = match motion {
        _ if of_calibration.is_some() => of_calibration.map(|to_world| Pose { to_world, vertical_fov_rad: None }),
        Some(motion) if motion.is_absolute() => {
            Some(Pose { to_world: motion.pose(&DAffine3::IDENTITY, 0.0), vertical_fov_rad: None })
        }
        Some(_) | None => pose(camera, &scene.cameras).map_err(|invalid| invalid.within("camera"))?,
    };
    let prescribed = Prescribed::of(finder, lens, warnings).map_err(|invalid| invalid.within("lens"))?;
    let size = lens_size(lens, sensor, prescribed.as_ref(), calibrated).map_err(|invalid| invalid.within("lens"))?;
    let sphere = bounding_sphere(scene);
    let focus_on_scene = matches!(&lens.focus_distance_m, Some(FocusDistance::Name(name)) if name == ON_SCENE);
    let (pose, is_framed) = match (pose, sphere) {
        (Some(pose), _) => (pose, false),
        (None, Some(sphere)) => {
            let to_world = Framing::of(&sphere, sensor, size).to_world();
            (Pose { to_world, vertical_fov_rad: None }, true)
        }
        (None, None) => {
            let help = "write [camera] with position_m and look_at_m, or name geometry";
            return Err(Invalid::new("camera", "there is none, and no geometry to look at").help(help));
        }
    };
    // The distance of the middle of the scene along the axis.
    let distance = |sphere: Sphere| pose.to_world.matrix3.z_axis.dot(pose.to_world.translation - sphere.centre);
    let focus_distance = sphere.filter(|_| is_framed || focus_on_scene).map(distance);
    let (LensSize::FocalLength(focal_length_m) | LensSize::ImageDistance(focal_length_m)) = size;
    // What lies behind the camera or within its focal length cannot be focused on.
    let default_focus = focus_distance.filter(|u| *u > 1.05 * focal_length_m).map(Focus::Distance);
    let lens =
        describe_lens(finder, lens, (prescribed, calibrated), sensor, pose.vertical_fov_rad, default_focus, warnings);
    Ok((pose.to_world, lens.map_err(|invalid| invalid.within("lens"))?))
}

/// Size of a lens, by its table.
pub(crate) fn lens_size(
    lens: &LensTable,
    sensor: &SensorModel,
    prescribed: Option<&Prescribed>,
    calibrated: Option<&Calibrated>,
) -> Result<LensSize, Invalid> {
    if let (Some(calibrated), None) = (calibrated, lens.focal_length_mm) {
        return Ok(LensSize::ImageDistance(calibrated.intrinsics.fy * sensor.pixel_pitch_m[1]));
    }
    if let Some(distance_m) = image_distance_of_field(lens, sensor)? {
        return Ok(LensSize::ImageDistance(distance_m));
    }
    let stated_mm = match prescribed {
        Some(prescribed) => lens.focal_length_mm.or(Some(prescribed.first_order().efl_mm)),
        None => lens.image_distance_mm.or(lens.focal_length_mm),
    };
    Ok(LensSize::FocalLength(stated_mm.map_or(DEFAULT_FOCAL_LENGTH_M, |mm| mm.abs() / 1e3)))
}

/// Refuses keys that place the camera beside its calibration.
fn refuse_other_poses(table: &CameraTable, moves: bool) -> Result<(), Invalid> {
    for (key, is_given) in [
        ("position_m", table.position_m.is_some()),
        ("look_at_m", table.look_at_m.is_some()),
        ("up", table.up.is_some()),
        ("gltf_camera", table.gltf_camera.is_some()),
        ("motion", moves),
    ] {
        if is_given {
            let message = "cannot be combined with calibration_pose, which places the camera";
            return Err(Invalid::new(key, message).help("keep one of them"));
        }
    }
    Ok(())
}

/// Pose of a camera, with the field of view if its file states one.
struct Pose {
    to_world: DAffine3,
    vertical_fov_rad: Option<f64>,
}

/// The camera that the table asks for, else the first of the scene's files.
fn pose(table: &CameraTable, cameras: &[CameraDescription]) -> Result<Option<Pose>, Invalid> {
    let of_file = |camera: &CameraDescription| Pose {
        to_world: camera.to_world,
        vertical_fov_rad: Some(camera.vertical_fov_rad),
    };
    if let Some(name) = &table.gltf_camera {
        for (key, is_given) in [
            ("position_m", table.position_m.is_some()),
            ("look_at_m", table.look_at_m.is_some()),
            ("up", table.up.is_some()),
        ] {
            if is_given {
                return Err(Invalid::new(key, "cannot be combined with gltf_camera").help("remove one of them"));
            }
        }
        let names = || cameras.iter().map(|camera| camera.name.as_str());
        return match cameras.iter().find(|camera| camera.name == *name) {
            Some(camera) => Ok(Some(of_file(camera))),
            None => {
                let message = format!("the geometry has no camera {name:?}{}", did_you_mean(name, names()));
                let help = if cameras.is_empty() {
                    "it has no cameras; write position_m and look_at_m instead".to_owned()
                } else {
                    format!("its cameras are {}", list(name, names()))
                };
                Err(Invalid::new("gltf_camera", message).help(help))
            }
        };
    }
    match (table.position_m, table.look_at_m) {
        (Some(position), Some(target)) => {
            let to_world = looking(position, target, table.up)?;
            Ok(Some(Pose { to_world, vertical_fov_rad: None }))
        }
        (None, None) if table.up.is_some() => Err(Invalid::new("up", "needs position_m and look_at_m")),
        (None, None) => Ok(cameras.first().map(of_file)),
        (Some(_), None) => {
            Err(Invalid::new("", "the key `look_at_m` is missing")
                .help("write a point on the axis, look_at_m = [x, y, z]"))
        }
        (None, Some(_)) => {
            Err(Invalid::new("", "the key `position_m` is missing")
                .help("write where the lens is, position_m = [x, y, z]"))
        }
    }
}
