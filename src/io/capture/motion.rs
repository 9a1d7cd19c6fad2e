//! `[camera.motion]`: how the camera moves while it records.

use glam::{DQuat, DVec3};

use super::camera::looking;
use super::light::vector;
use super::settings::{ExposureSettings, ExposureTime};
use super::tables::{CameraTable, MotionTable, PoseTable};
use crate::Invalid;
use crate::optics::{CameraMotion, Recording, TimedPose};
use crate::sensor::SensorModel;

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
    let at = |i: usize| move |invalid: Invalid| invalid.within(&format!("poses[{i}]"));
    let poses: Vec<TimedPose> =
        poses.iter().enumerate().map(|(i, pose)| timed_pose(pose).map_err(at(i))).collect::<Result<_, _>>()?;
    if poses.len() < 2 {
        return Err(
            Invalid::new("poses", "a motion needs at least two").help("for a camera that stands still, write [camera]")
        );
    }
    if let Some(i) = (1..poses.len()).find(|&i| poses[i].time_s <= poses[i - 1].time_s) {
        let message = format!("{} s is not after {} s", poses[i].time_s, poses[i - 1].time_s);
        return Err(at(i)(Invalid::new("time_s", message).help("write the poses in the order of their times")));
    }
    Ok(Some(CameraMotion::Poses(poses)))
}

fn steady(table: &MotionTable) -> Result<Option<CameraMotion>, Invalid> {
    let velocity_m_per_s = vector("velocity_m_per_s", table.velocity_m_per_s.unwrap_or_default())?;
    let degrees = vector("angular_velocity_deg_per_s", table.angular_velocity_deg_per_s.unwrap_or_default())?;
    let angular_velocity_rad_per_s = degrees * (std::f64::consts::PI / 180.0);
    let moves = velocity_m_per_s != DVec3::ZERO || angular_velocity_rad_per_s != DVec3::ZERO;
    Ok(moves.then_some(CameraMotion::Steady { velocity_m_per_s, angular_velocity_rad_per_s }))
}

fn timed_pose(table: &PoseTable) -> Result<TimedPose, Invalid> {
    if !table.time_s.is_finite() {
        return Err(Invalid::new("time_s", format!("must be finite, got {}", table.time_s)));
    }
    let to_world = looking(table.position_m, table.look_at_m, table.up)?;
    let rotation = DQuat::from_mat3(&to_world.matrix3);
    Ok(TimedPose { time_s: table.time_s, position_m: to_world.translation, rotation })
}

/// The first picture that a moving camera takes.
pub(super) fn recording(
    motion: CameraMotion,
    exposure: &ExposureSettings,
    sensor: &SensorModel,
) -> Result<Recording, Invalid> {
    let ExposureTime::Fixed(time) = exposure.time else {
        let message = "needs an exposure time, which tells how far the camera comes meanwhile";
        return Err(
            Invalid::new("camera.motion", message).help("write [exposure] with time_s, for example time_s = 0.01")
        );
    };
    Ok(Recording {
        motion,
        start_s: 0.0,
        exposure_s: time.0,
        row_time_s: sensor.shutter.row_time().0,
        first_row: sensor.shutter.first_row(sensor.resolution[1]),
        frame_interval_s: sensor.frame_interval(time, exposure.frame_interval).0,
    })
}
