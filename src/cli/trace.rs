//! Tracing with everything that goes on beside it: progress, pictures of the state so far, limits of time and noise.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::Instant;

use photosite::Result;
use photosite::film::{Film, FilmResponses, Response};
use photosite::integrator::{RenderJob, Step, render};
use photosite::io::capture::Capture;
use photosite::optics::Camera;
use photosite::scene::Scene;
use photosite::spectrum::Spectrum;

use super::chain::Chain;
use super::output_folder::OutputFolder;
use super::progress::Progress;
use super::render::pixels;

/// What tracing reads.
pub(super) struct Trace<'a> {
    pub(super) capture: &'a Capture,
    pub(super) scene: &'a Scene,
    pub(super) camera: &'a Camera,
    pub(super) responses: &'a [Response],
    pub(super) importance: &'a Spectrum,
    pub(super) chain: &'a Chain<'a>,
    pub(super) folder: &'a OutputFolder,
    pub(super) silent: bool,
}

/// Traces until the samples, the time or the noise that was asked for is reached.
pub(super) fn trace(t: &Trace<'_>) -> Result<Film> {
    let settings = &t.capture.render;
    let resolution = pixels(t.capture);
    let per_sample = u64::from(resolution[0]) * u64::from(resolution[1]);
    let progress = Progress::new(per_sample * u64::from(settings.samples_per_pixel), t.silent);
    let previews = Mutex::new(Previews { last: Instant::now(), failure: None });
    let step = |step: Step<'_>| match step {
        Step::Row { paths } => {
            progress.advance(paths);
            ControlFlow::Continue(())
        }
        Step::Pass { film, elapsed } => {
            progress.pass(film.samples());
            let quiet_enough = |target| t.chain.noise_ratio(film).is_some_and(|ratio| ratio <= target);
            let done = film.samples() >= settings.samples_per_pixel
                || settings.time_limit.is_some_and(|limit| elapsed >= limit)
                || settings.noise_target.is_some_and(quiet_enough);
            if done || previews.lock().expect("nobody panics while holding it").show(t, film).is_err() {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        }
    };
    let job = RenderJob {
        scene: t.scene,
        camera: t.camera,
        transmittance: &t.capture.lens.transmittance,
        importance: t.importance,
        resolution,
        settings,
    };
    let film = render(&job, FilmResponses::new(t.responses), &step);
    progress.finish();
    match previews.into_inner().expect("nobody panics while holding it").failure {
        Some(error) => Err(error),
        None => Ok(film),
    }
}

/// Pictures of a render that is under way.
struct Previews {
    last: Instant,
    failure: Option<photosite::Error>,
}

impl Previews {
    /// Writes a picture if it is time for one. What goes wrong is kept, and ends the render.
    fn show(&mut self, t: &Trace<'_>, film: &Film) -> Result<(), ()> {
        if t.capture.output.preview_interval.is_none_or(|interval| self.last.elapsed() < interval) {
            return Ok(());
        }
        // Too little light for an exposure yet is no failure: there is nothing to show.
        let Ok(exposed) = t.chain.expose(&t.chain.rates(film)) else { return Ok(()) };
        let raw = t.chain.read_out(&exposed, 0);
        let shown = raw.and_then(|raw| t.chain.develop(&raw)).and_then(|picture| t.folder.write_preview(&picture));
        self.last = Instant::now();
        shown.map_err(|error| self.failure = Some(error))
    }
}
