//! Motion of cameras and objects: `motion` of `[camera]` and `[[scene.objects]]`.

use glam::{DAffine3, DVec3};

use super::super::tables::{
    CameraMotionTable, CameraTable, ObjectMotionTable, ObjectPoseTable, ObjectTable, PoseTable, TurntableTable,
};
use super::object_pose;
use photosite_calibration::dataset::InterpolationName;
use photosite_core::Invalid;
use photosite_transport::geometry::{TimedPose, Trajectory};
use photosite_transport::optics::Recording;
use photosite_transport::scene::description::{CameraDescription, looking, vector};

/// Motion of the camera of the table; `None` if it stands still.
pub(crate) fn of_camera(camera: &CameraTable) -> Result<Option<Trajectory>, Invalid> {
    let Some(table) = &camera.motion else { return Ok(None) };
    let pose =
        |(i, table): (usize, &PoseTable)| timed_pose(table).map_err(|invalid| invalid.within(&format!("poses[{i}]")));
    let poses = table.poses.as_ref().map(|poses| poses.iter().enumerate().map(pose).collect()).transpose()?;
    let stated = [
        ("position_m", camera.position_m.is_some()),
        ("look_at_m", camera.look_at_m.is_some()),
        ("up", camera.up.is_some()),
        ("gltf_camera", camera.gltf_camera.is_some()),
    ];
    refuse_pose(poses.is_some(), &stated, "[camera]")?;
    let CameraMotionTable { velocity_m_per_s, angular_velocity_deg_per_s, turntable, poses: _, interpolation } = table;
    let centre = || {
        camera.look_at_m.ok_or_else(|| {
            Invalid::new("turntable.centre_m", "is missing, and [camera] has no look_at_m to stand for it")
                .help("write a point of the axis, centre_m = [x, y, z]")
        })
    };
    Stated {
        velocities: [*velocity_m_per_s, *angular_velocity_deg_per_s],
        turntable: turntable.as_ref(),
        poses,
        interpolation: *interpolation,
    }
    .trajectory(centre, "for a camera that stands still, write [camera]")
}

/// Motion of an object; `None` if it stands still.
pub(crate) fn of_object(object: &ObjectTable) -> Result<Option<Trajectory>, Invalid> {
    let Some(table) = &object.motion else { return Ok(None) };
    let pose = |(i, table): (usize, &ObjectPoseTable)| {
        let rotation = object_pose::rotation(
            DVec3::from_array(table.position_m),
            [table.rotation_deg, table.look_at_m],
            table.quaternion_wxyz,
        );
        let position_m = vector("position_m", table.position_m);
        let pose = |rotation| Ok(TimedPose { time_s: table.time_s, position_m: position_m?, rotation });
        rotation.and_then(pose).map_err(|invalid| invalid.within(&format!("poses[{i}]")))
    };
    let poses = table.poses.as_ref().map(|poses| poses.iter().enumerate().map(pose).collect()).transpose()?;
    let stated = [
        ("position_m", object.position_m.is_some()),
        ("rotation_deg", object.rotation_deg.is_some()),
        ("quaternion_wxyz", object.quaternion_wxyz.is_some()),
        ("look_at_m", object.look_at_m.is_some()),
    ];
    refuse_pose(poses.is_some(), &stated, "the object")?;
    let ObjectMotionTable { velocity_m_per_s, angular_velocity_deg_per_s, turntable, poses: _, interpolation } = table;
    Stated {
        velocities: [*velocity_m_per_s, *angular_velocity_deg_per_s],
        turntable: turntable.as_ref(),
        poses,
        interpolation: *interpolation,
    }
    .trajectory(|| Ok(object.position_m.unwrap_or_default()), "for an object that stands still, leave motion out")
}

/// Refuses a pose of the object beside poses of its motion, which stand for themselves.
fn refuse_pose(has_poses: bool, stated: &[(&str, bool)], of: &str) -> Result<(), Invalid> {
    match stated.iter().find(|(_, is_given)| has_poses && *is_given) {
        None => Ok(()),
        Some((key, _)) => {
            let message = format!("cannot be combined with {key} of {of}: poses say where it stands at all times");
            Err(Invalid::new("poses", message).help(format!("remove {key}")))
        }
    }
}

/// Motion that a table states, in one of three ways.
struct Stated<'a> {
    /// Velocities along the world's axes, m/s, and about the own ones, degrees per second.
    velocities: [Option<[f64; 3]>; 2],
    turntable: Option<&'a TurntableTable>,
    poses: Option<Vec<TimedPose>>,
    interpolation: Option<InterpolationName>,
}

impl Stated<'_> {
    /// Trajectory that the table states. `centre` is a point of the turntable's axis where none is given, and `still`
    /// what the help says of what does not move.
    fn trajectory(
        self,
        centre: impl Fn() -> Result<[f64; 3], Invalid>,
        still: &str,
    ) -> Result<Option<Trajectory>, Invalid> {
        let Self { velocities: [velocity, angular_velocity], turntable, poses, interpolation } = self;
        let kinds = [
            ("poses", poses.is_some()),
            ("turntable", turntable.is_some()),
            ("velocity_m_per_s", velocity.is_some()),
            ("angular_velocity_deg_per_s", angular_velocity.is_some()),
        ];
        let given: Vec<&str> = kinds.iter().filter(|(_, is_given)| *is_given).map(|(key, _)| *key).collect();
        if let &[first @ ("poses" | "turntable"), second, ..] = &*given {
            return Err(Invalid::new(second, format!("cannot be combined with {first}")).help("keep one of them"));
        }
        if interpolation.is_some() && poses.is_none() {
            let message = "only applies with poses, between which it says how to go";
            return Err(Invalid::new("interpolation", message).help("write poses, or remove it"));
        }
        if let Some(poses) = poses {
            return Trajectory::through(poses, interpolation.unwrap_or_default().into(), still).map(Some);
        }
        if let Some(table) = turntable {
            return on_turntable(table, centre).map(Some);
        }
        let velocity_m_per_s = vector("velocity_m_per_s", velocity.unwrap_or_default())?;
        let degrees = vector("angular_velocity_deg_per_s", angular_velocity.unwrap_or_default())?;
        let angular_velocity_rad_per_s = degrees * (std::f64::consts::PI / 180.0);
        let moves = velocity_m_per_s != DVec3::ZERO || angular_velocity_rad_per_s != DVec3::ZERO;
        Ok(moves.then_some(Trajectory::Steady { velocity_m_per_s, angular_velocity_rad_per_s }))
    }
}

fn on_turntable(table: &TurntableTable, centre: impl Fn() -> Result<[f64; 3], Invalid>) -> Result<Trajectory, Invalid> {
    let centre_m = match table.centre_m {
        Some(stated) => vector("turntable.centre_m", stated)?,
        None => DVec3::from_array(centre()?),
    };
    let axis = vector("turntable.axis", table.axis.unwrap_or([0.0, 1.0, 0.0]))?;
    let axis = axis.try_normalize().ok_or_else(|| {
        Invalid::new("turntable.axis", "has no length").help("for example [0, 1, 0], about which it turns upright")
    })?;
    let speed = table.speed_deg_per_s;
    if !speed.is_finite() {
        return Err(Invalid::new("turntable.speed_deg_per_s", format!("must be finite, got {speed}")));
    }
    Ok(Trajectory::Turntable { centre_m, axis, speed_rad_per_s: speed.to_radians() })
}

fn timed_pose(table: &PoseTable) -> Result<TimedPose, Invalid> {
    Ok(TimedPose::new(table.time_s, &looking(table.position_m, table.look_at_m, table.up)?))
}

/// Motion of the glTF camera that the table takes, in an image that is taken at that time.
pub(crate) fn motion_of_file(
    table: &CameraTable,
    cameras: &[CameraDescription],
    recording: &Recording,
) -> Option<Trajectory> {
    let camera = match &table.gltf_camera {
        Some(name) => cameras.iter().find(|camera| camera.name == *name),
        None => cameras.first().filter(|_| table.position_m.is_none()),
    }?;
    let parts = camera.later.len() as f64;
    let pose = |(i, place): (usize, &DAffine3)| {
        TimedPose::new(recording.start_s + recording.duration_s * i as f64 / parts, place)
    };
    let places = || [&camera.to_world].into_iter().chain(&camera.later);
    (parts > 0.0).then(|| Trajectory::Poses(places().enumerate().map(pose).collect()))
}
