//! Moments of an image: when it is taken, and how much of that time each row sees.

use super::super::settings::exposure::{self, ExposureSettings, ExposureTime};
use super::super::settings::sensor::sensor_model;
use super::super::tables::{CaptureFile, ObjectTable, SceneTable};
use photosite_core::Invalid;
use photosite_core::Sandbox;
use photosite_scene_io::gltf::Moment;
use photosite_sensor::SensorModel;
use photosite_transport::geometry::Trajectory;
use photosite_transport::optics::Recording;

/// Moments at which an image is taken of animations and objects that move.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moments {
    /// Moment of the animation of `scene.geometry`, if it has one.
    pub of_scene: Option<Moment>,
    /// Moment of the animation of each object.
    pub of_objects: Vec<Option<Moment>>,
    /// Span of objects that move along a trajectory, if there are any.
    pub of_trajectories: Option<Span>,
}

/// A time on the clock of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    /// Begin, s.
    pub start_s: f64,
    /// Duration, s.
    pub duration_s: f64,
}

impl Moments {
    /// Moments of the image of that number.
    pub(crate) fn of(file: &CaptureFile, frame: u32, sandbox: &Sandbox) -> Result<Self, Invalid> {
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

/// Moment of an animation, if there is one, in the image of that span. Keys of errors are `animation` and
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

/// Recording of the first image of something that moves. `key` names what does.
pub(crate) fn recording(
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
