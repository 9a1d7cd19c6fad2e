//! When a picture is taken, and how much of that time each row sees.

use super::exposure::{self, ExposureSettings, ExposureTime};
use super::sensor::sensor_model;
use super::tables::{CaptureFile, ObjectTable, SceneTable};
use crate::Invalid;
use crate::geometry::Trajectory;
use crate::io::gltf::Moment;
use crate::optics::Recording;
use crate::sensor::SensorModel;
use photosite_core::Sandbox;

/// When a picture is taken of what moves in a scene.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moments {
    /// Of the animation of `scene.geometry`, if it has one.
    pub(super) of_scene: Option<Moment>,
    /// Of that of each object.
    pub(super) of_objects: Vec<Option<Moment>>,
    /// Of objects that move along a trajectory, if there are any.
    pub(super) of_trajectories: Option<Span>,
}

/// A time on the clock of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    /// s.
    pub(super) start_s: f64,
    /// s.
    pub(super) duration_s: f64,
}

impl Moments {
    /// Those of the picture of that number.
    pub(super) fn of(file: &CaptureFile, frame: u32, sandbox: &Sandbox) -> Result<Self, Invalid> {
        let SceneTable { animation, animation_time_s, objects, time_s, .. } = &file.scene;
        let mover = file.scene.mover();
        let Some(mover) = mover else {
            if time_s.is_some() {
                return Err(Invalid::new("scene.time_s", "only applies with an animation, or objects that move")
                    .help("remove it, or give an object motion or an animation"));
            }
            refuse_time(animation.as_ref(), *animation_time_s).map_err(|invalid| invalid.within("scene"))?;
            for (i, object) in objects.iter().enumerate() {
                let refused = refuse_time(object.animation.as_ref(), object.animation_time_s);
                refused.map_err(|invalid| invalid.within(&format!("scene.objects[{i}]")))?;
            }
            return Ok(Self { of_scene: None, of_objects: vec![None; objects.len()], of_trajectories: None });
        };
        let start_s = finite("scene.time_s", time_s.unwrap_or(0.0))?;
        let sensor = sensor_model(&file.sensor, sandbox).map_err(|invalid| invalid.within("sensor"))?;
        let exposure = exposure::exposure(&file.exposure, &sensor).map_err(|invalid| invalid.within("exposure"))?;
        let taken = recording(&mover, None, &exposure, &sensor)?.later(frame);
        let span = Span { start_s: start_s + taken.start_s, duration_s: taken.duration_s };
        let of_object = |(i, object): (usize, &ObjectTable)| {
            let found = moment(object.animation.as_ref(), object.animation_time_s, span);
            found.map_err(|invalid| invalid.within(&format!("scene.objects[{i}]")))
        };
        let of_scene = moment(animation.as_ref(), *animation_time_s, span);
        Ok(Self {
            of_scene: of_scene.map_err(|invalid| invalid.within("scene"))?,
            of_objects: objects.iter().enumerate().map(of_object).collect::<Result<_, _>>()?,
            of_trajectories: objects.iter().any(|object| object.motion.is_some()).then_some(span),
        })
    }
}

/// When the picture of that time is taken of an animation, if there is one. Keys of errors are `animation` and
/// `animation_time_s`.
fn moment(animation: Option<&String>, time_s: Option<f64>, span: Span) -> Result<Option<Moment>, Invalid> {
    refuse_time(animation, time_s)?;
    let Some(animation) = animation else { return Ok(None) };
    let start_s = finite("animation_time_s", time_s.unwrap_or(0.0))? + span.start_s;
    Ok(Some(Moment { animation: animation.clone(), start_s, duration_s: span.duration_s }))
}

/// Refuses the time of an animation where there is none.
fn refuse_time(animation: Option<&String>, time_s: Option<f64>) -> Result<(), Invalid> {
    match (animation, time_s) {
        (None, Some(_)) => Err(Invalid::new("animation_time_s", "only applies with an animation")
            .help("remove it, or name an animation, for example animation = \"Walk\"")),
        (None, None) | (Some(_), _) => Ok(()),
    }
}

fn finite(key: &str, time_s: f64) -> Result<f64, Invalid> {
    if time_s.is_finite() { Ok(time_s) } else { Err(Invalid::new(key, format!("must be finite, got {time_s}"))) }
}

/// The first picture of something that moves. `key` names what does.
pub(super) fn recording(
    key: &str,
    motion: Option<Trajectory>,
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
