//! Tracing with everything that goes on beside it: progress, pictures of the state so far, checkpoints, limits of time and noise.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use photosite::Result;
use photosite::film::{Film, FilmResponses, Response};
use photosite::integrator::{RenderJob, RenderSettings, Step, render_on, render_with_pilot};
use photosite::io::capture::Capture;
use photosite::optics::Camera;
use photosite::scene::Scene;
use photosite::spectrum::Spectrum;
use photosite::units::Seconds;

use super::chain::Chain;
use super::checkpoint::Checkpoints;
use super::output_folder::OutputFolder;
use super::progress::Progress;
use super::render::pixels;

/// What tracing reads.
pub(super) struct Trace<'a> {
    pub(super) capture: &'a Capture,
    /// Those of the capture, with a seed for this frame.
    pub(super) settings: &'a RenderSettings,
    pub(super) scene: &'a Scene,
    pub(super) camera: &'a Camera,
    pub(super) responses: &'a [Response],
    pub(super) importance: &'a Spectrum,
    pub(super) chain: &'a Chain<'a>,
    pub(super) folder: &'a OutputFolder,
    pub(super) silent: bool,
}

/// Light that was traced.
pub(super) struct Traced {
    pub(super) film: Film,
    /// Paths that are not in the film, but found how many are.
    pub(super) pilot_paths: u64,
    /// Time that was spent on it before a checkpoint.
    pub(super) earlier: Duration,
}

/// Traces until the samples, the time or the noise that was asked for is reached, from the last checkpoint on.
pub(super) fn trace(t: &Trace<'_>, checkpoints: Checkpoints<'_>) -> Result<Traced> {
    let settings = t.settings;
    let job = RenderJob {
        scene: t.scene,
        camera: t.camera,
        transmittance: &t.capture.lens.transmittance,
        importance: t.importance,
        resolution: pixels(t.capture),
        settings,
    };
    let mut film = job.empty_film(FilmResponses::new(t.responses));
    // The sensor's channels come first.
    let of_sensor = || job.empty_film(FilmResponses::new(&t.responses[..t.capture.sensor.cfa.channels().len()]));
    let mut pilot = settings.noise_target.map(|_| of_sensor());
    let earlier = checkpoints.resume(&mut film, pilot.as_mut())?;
    if earlier.is_some() && !t.silent {
        let (path, samples) = (checkpoints.path().display(), film.total() / film.counts().len() as u64);
        eprintln!("goes on from {path} at {samples} samples a pixel");
    }
    let earlier = earlier.unwrap_or_default();
    let paths_of = |film: &Film, pilot: Option<&Film>| film.total() + pilot.map_or(0, Film::total);

    let asked_for = film.counts().len() as u64 * u64::from(settings.samples_per_pixel);
    let progress = Progress::new(asked_for, t.silent).starting_at(paths_of(&film, pilot.as_ref()));
    let beside = Mutex::new(Beside { checkpoints, last_preview: Instant::now(), failure: None });
    let step = |step: Step<'_>| match step {
        Step::Row { paths } => {
            progress.advance(paths);
            ControlFlow::Continue(())
        }
        Step::Pass { film, pilot, elapsed, planned_paths } => {
            let elapsed = earlier + elapsed;
            let planned = planned_paths.unwrap_or(asked_for);
            progress.pass(film, expected_paths(settings, paths_of(film, pilot), elapsed, planned));
            if settings.time_limit.is_some_and(|limit| elapsed >= limit) {
                return ControlFlow::Break(());
            }
            beside.lock().expect("nobody panics while holding it").keep(t, film, pilot, elapsed)
        }
    };
    match (settings.noise_target, &mut pilot) {
        (Some(target), Some(pilot)) => {
            let needed = |pilot: &Film| t.chain.samples_needed(pilot, target);
            render_with_pilot(&job, &mut film, pilot, &needed, &step);
        }
        _ => render_on(&job, &mut film, &step),
    }
    progress.finish();
    match beside.into_inner().expect("nobody panics while holding it").failure {
        Some(error) => Err(error),
        None => Ok(Traced { pilot_paths: paths_of(&film, pilot.as_ref()) - film.total(), film, earlier }),
    }
}

/// How many paths there will be in all, as far as can be told after a pass that brought them to `done`: those that are
/// planned, or those that fit into the time.
fn expected_paths(settings: &RenderSettings, done: u64, elapsed: Duration, planned: u64) -> u64 {
    let in_time = settings.time_limit.map(|limit| done as f64 * limit.as_secs_f64() / elapsed.as_secs_f64());
    in_time.map_or(planned, |paths| planned.min(paths as u64)).max(done)
}

/// What is written of a render that is under way.
struct Beside<'a> {
    checkpoints: Checkpoints<'a>,
    last_preview: Instant,
    failure: Option<photosite::Error>,
}

impl Beside<'_> {
    /// Writes what it is time for. What goes wrong is kept, and ends the render.
    fn keep(&mut self, t: &Trace<'_>, film: &Film, pilot: Option<&Film>, elapsed: Duration) -> ControlFlow<()> {
        let written = self.checkpoints.keep(film, pilot, elapsed).and_then(|()| self.show(t, film));
        match written {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.failure = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    /// Writes a picture if it is time for one.
    fn show(&mut self, t: &Trace<'_>, film: &Film) -> Result<()> {
        if t.capture.output.preview_interval.is_none_or(|interval| self.last_preview.elapsed() < interval) {
            return Ok(());
        }
        // Too little light for an exposure yet is no failure: there is nothing to show.
        let Ok(exposed) = t.chain.expose(t.chain.rates(film), Seconds(1.0), None) else { return Ok(()) };
        let raw = t.chain.read_out(&exposed, 0)?;
        t.folder.write_preview(&t.chain.develop(&raw)?)?;
        self.last_preview = Instant::now();
        Ok(())
    }
}
