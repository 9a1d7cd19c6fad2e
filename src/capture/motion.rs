//! `[camera.motion]` and `scene.animation`: how camera and scene move while a picture is taken.

use glam::{DAffine3, DVec3};

use super::sensor::sensor_model;
use super::settings::{self, ExposureSettings, ExposureTime};
use super::tables::{CameraTable, CaptureFile, MotionTable, ObjectTable, PoseTable, SceneTable};
use crate::Invalid;
use crate::io::gltf::Moment;
use crate::optics::{CameraMotion, Recording, TimedPose};
use crate::scene::description::{CameraDescription, looking, vector};
use crate::sensor::SensorModel;
use photosite_core::Sandbox;

/// How the camera of the table moves; `None` if it stands still.
pub(super) fn motion(camera: &CameraTable) -> Result<Option<CameraMotion>, Invalid> {
    let Some(table) = &camera.motion else { return Ok(None) };
    let Some(poses) = &table.poses else { return steady(table) };
    let surplus = [
        ("velocity_m_per_s", table.velocity_m_per_s.is_some()),
        ("angular_velocity_deg_per_s", table.angular_velocity_deg_per_s.is_some()),
    ];
    if let Some((key, _)) = surplus.iter().find(|(_, is_given)| *is_given) {
        return Err(Invalid::new(*key, "cannot go with poses").help("keep one of them"));
    }
    let of_camera = [
        ("position_m", camera.position_m.is_some()),
        ("look_at_m", camera.look_at_m.is_some()),
        ("up", camera.up.is_some()),
        ("gltf_camera", camera.gltf_camera.is_some()),
    ];
    if let Some((key, _)) = of_camera.iter().find(|(_, is_given)| *is_given) {
        let message = format!("cannot go with {key} of [camera]: poses say where the camera stands at all times");
        return Err(Invalid::new("poses", message).help(format!("remove {key}")));
    }
    let pose =
        |(i, table): (usize, &PoseTable)| timed_pose(table).map_err(|invalid| invalid.within(&format!("poses[{i}]")));
    let poses = poses.iter().enumerate().map(pose).collect::<Result<_, Invalid>>()?;
    CameraMotion::through(poses, "for a camera that stands still, write [camera]").map(Some)
}

fn steady(table: &MotionTable) -> Result<Option<CameraMotion>, Invalid> {
    let velocity_m_per_s = vector("velocity_m_per_s", table.velocity_m_per_s.unwrap_or_default())?;
    let degrees = vector("angular_velocity_deg_per_s", table.angular_velocity_deg_per_s.unwrap_or_default())?;
    let angular_velocity_rad_per_s = degrees * (std::f64::consts::PI / 180.0);
    let moves = velocity_m_per_s != DVec3::ZERO || angular_velocity_rad_per_s != DVec3::ZERO;
    Ok(moves.then_some(CameraMotion::Steady { velocity_m_per_s, angular_velocity_rad_per_s }))
}

fn timed_pose(table: &PoseTable) -> Result<TimedPose, Invalid> {
    Ok(TimedPose::new(table.time_s, &looking(table.position_m, table.look_at_m, table.up)?))
}

/// The motion of the glTF camera that the table takes, in a picture that is taken at that time.
pub(super) fn motion_of_file(
    table: &CameraTable,
    cameras: &[CameraDescription],
    recording: &Recording,
) -> Option<CameraMotion> {
    let camera = match &table.gltf_camera {
        Some(name) => cameras.iter().find(|camera| camera.name == *name),
        None => cameras.first().filter(|_| table.position_m.is_none()),
    }?;
    let parts = camera.later.len() as f64;
    let pose = |(i, place): (usize, &DAffine3)| {
        TimedPose::new(recording.start_s + recording.duration_s * i as f64 / parts, place)
    };
    let places = || [&camera.to_world].into_iter().chain(&camera.later);
    (parts > 0.0).then(|| CameraMotion::Poses(places().enumerate().map(pose).collect()))
}

/// When a picture is taken of the animations of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moments {
    /// Of the animation of `scene.geometry`, if it has one.
    pub(super) of_scene: Option<Moment>,
    /// Of that of each object.
    pub(super) of_objects: Vec<Option<Moment>>,
}

impl Moments {
    /// Those of the picture of that number.
    pub(super) fn of(file: &CaptureFile, frame: u32, sandbox: &Sandbox) -> Result<Self, Invalid> {
        let SceneTable { animation, animation_time_s, objects, .. } = &file.scene;
        let of_scene = moment(file, animation.as_ref(), *animation_time_s, frame, sandbox);
        let of_object = |(i, object): (usize, &ObjectTable)| {
            let found = moment(file, object.animation.as_ref(), object.animation_time_s, frame, sandbox);
            found.map_err(|invalid| invalid.within(&format!("scene.objects[{i}]")))
        };
        Ok(Self {
            of_scene: of_scene.map_err(|invalid| invalid.within("scene"))?,
            of_objects: objects.iter().enumerate().map(of_object).collect::<Result<_, _>>()?,
        })
    }
}

/// When the picture of that number is taken of an animation, if there is one. Keys of errors are `animation` and
/// `animation_time_s`.
fn moment(
    file: &CaptureFile,
    animation: Option<&String>,
    time_s: Option<f64>,
    frame: u32,
    sandbox: &Sandbox,
) -> Result<Option<Moment>, Invalid> {
    let Some(animation) = animation else {
        return match time_s {
            None => Ok(None),
            Some(_) => Err(Invalid::new("animation_time_s", "goes only with an animation")
                .help("remove it, or name an animation, for example animation = \"Walk\"")),
        };
    };
    let start_s = time_s.unwrap_or(0.0);
    if !start_s.is_finite() {
        return Err(Invalid::new("animation_time_s", format!("must be finite, got {start_s}")));
    }
    let sensor = sensor_model(&file.sensor, sandbox).map_err(|invalid| invalid.within("sensor"))?;
    let exposure = settings::exposure(&file.exposure, &sensor).map_err(|invalid| invalid.within("exposure"))?;
    let recording = recording("animation", None, &exposure, &sensor)?.later(frame);
    let start_s = start_s + recording.start_s;
    Ok(Some(Moment { animation: animation.clone(), start_s, duration_s: recording.duration_s }))
}

/// The first picture of something that moves. `key` names what does.
pub(super) fn recording(
    key: &str,
    motion: Option<CameraMotion>,
    exposure: &ExposureSettings,
    sensor: &SensorModel,
) -> Result<Recording, Invalid> {
    let ExposureTime::Fixed(time) = exposure.time else {
        let message = "needs an exposure time, which tells how far things come meanwhile";
        return Err(Invalid::new(key, message).help("write [exposure] with time_s, for example time_s = 0.01"));
    };
    let rows = sensor.resolution[1];
    let last = (0..rows).map(|row| sensor.shutter.delay(row, rows).0).fold(0.0, f64::max);
    Ok(Recording {
        motion,
        start_s: 0.0,
        exposure_s: time.0,
        row_time_s: sensor.shutter.row_time().0,
        first_row: sensor.shutter.first_row(rows),
        duration_s: last + time.0,
        frame_interval_s: sensor.frame_interval(time, exposure.frame_interval).0,
    })
}
