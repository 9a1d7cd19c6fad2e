//! Tracing with everything that goes on beside it: progress, pictures of the state so far, limits of time and noise.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use photosite::Result;
use photosite::film::{Film, FilmResponses, Response};
use photosite::integrator::{RenderJob, RenderSettings, Step, render};
use photosite::io::capture::Capture;
use photosite::optics::Camera;
use photosite::scene::Scene;
use photosite::spectrum::Spectrum;
use photosite::units::Seconds;

use super::chain::Chain;
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

/// Traces until the samples, the time or the noise that was asked for is reached.
pub(super) fn trace(t: &Trace<'_>) -> Result<Film> {
    let settings = t.settings;
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
            let ratio = settings.noise_target.and_then(|_| t.chain.noise_ratio(film));
            progress.pass(film.samples(), expected_paths(settings, film, elapsed, ratio, per_sample));
            let done = film.samples() >= settings.samples_per_pixel
                || settings.time_limit.is_some_and(|limit| elapsed >= limit)
                || settings.noise_target.zip(ratio).is_some_and(|(target, ratio)| ratio <= target);
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

/// How many paths there will be in all, as far as can be told after a pass: all that were asked for, or those that fit
/// into the time, or that make the noise small enough.
fn expected_paths(
    settings: &RenderSettings,
    film: &Film,
    elapsed: Duration,
    noise_ratio: Option<f64>,
    per_sample: u64,
) -> u64 {
    let samples = f64::from(film.samples());
    let in_time = settings.time_limit.map(|limit| samples * limit.as_secs_f64() / elapsed.as_secs_f64());
    // Noise falls with the square root of the samples.
    let to_target = settings.noise_target.zip(noise_ratio).map(|(target, ratio)| samples * (ratio / target).powi(2));
    let asked_for = f64::from(settings.samples_per_pixel);
    let expected = [in_time, to_target].into_iter().flatten().fold(asked_for, f64::min);
    (expected.max(samples) * per_sample as f64) as u64
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
        let Ok(exposed) = t.chain.expose(t.chain.rates(film), Seconds(1.0), None) else { return Ok(()) };
        let raw = t.chain.read_out(&exposed, 0);
        let shown = raw.and_then(|raw| t.chain.develop(&raw)).and_then(|picture| t.folder.write_preview(&picture));
        self.last = Instant::now();
        shown.map_err(|error| self.failure = Some(error))
    }
}
