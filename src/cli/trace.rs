//! Tracing with everything that goes on beside it: progress, pictures of the state so far, checkpoints, limits of time and noise.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use photosite::Result;
use photosite::film::{Film, FilmResponses, Response};
use photosite::image::{Estimate, Planes};
use photosite::integrator::{
    FilterTile, Listener, Pilot, RenderJob, RenderSettings, Step, render_on, render_with_pilot,
};
use photosite::io::capture::Capture;
use photosite::io::film_file::film_bytes;
use photosite::io::light_rows::{LightRows, Store};
use photosite::optics::Camera;
use photosite::scene::Scene;
use photosite::units::Seconds;

use super::chain::Chain;
use super::checkpoint::{Checkpoints, Resumed};
use super::due::Due;
use super::film_memory::Strips;
use super::kept_rows::KeptRows;
use super::output_folder::OutputFolder;
use super::progress::Progress;
use super::render::pixels;
use super::signals::{Patience, stop, stopped};

/// What tracing reads.
pub(super) struct Trace<'a> {
    pub(super) capture: &'a Capture,
    /// Those of the capture, with a seed for this frame.
    pub(super) settings: &'a RenderSettings,
    pub(super) scene: &'a Scene,
    pub(super) camera: &'a Camera,
    pub(super) responses: &'a [Response],
    pub(super) filters: Option<&'a FilterTile>,
    pub(super) strips: Strips,
    /// Whether it is a part of a render, of which the sums are kept.
    pub(super) is_part: bool,
    pub(super) chain: &'a Chain<'a>,
    pub(super) folder: &'a OutputFolder,
    pub(super) silent: bool,
}

/// Light that was traced.
pub(super) struct Traced {
    pub(super) rows: KeptRows,
    /// Paths of the picture.
    pub(super) paths: u64,
    /// Paths that are not in it, but found how many are.
    pub(super) pilot_paths: u64,
    /// Time that was spent on it before a checkpoint.
    pub(super) earlier: Duration,
}

/// Traces until the samples, the time or the noise that was asked for is reached, from the last checkpoint on, one strip
/// after the other. A signal ends it with a checkpoint.
pub(super) fn trace(t: &Trace<'_>, mut checkpoints: Checkpoints<'_>) -> Result<Traced> {
    let start = Instant::now();
    let settings = t.settings;
    let job = RenderJob {
        scene: t.scene,
        camera: t.camera,
        transmittance: &t.capture.lens.transmittance,
        responses: t.responses,
        filters: t.filters,
        resolution: pixels(t.capture),
        settings,
    };
    let [width, height] = job.resolution.map(|n| n as usize);
    let responses = FilmResponses::new(t.responses);
    // The sensor's channels come first.
    let of_sensor = FilmResponses::new(&t.responses[..t.capture.sensor.cfa.channels().len()]);
    let per_row = width as u64 * settings.samples().len() as u64;
    let asked_for = per_row * height as u64;

    let (path, resumed) = (checkpoints.path().to_owned(), checkpoints.resume(t.strips)?);
    let is_resumed = resumed.is_some();
    let Resumed { first_row, elapsed: earlier, films: mut saved } =
        resumed.unwrap_or(Resumed { first_row: 0, elapsed: Duration::ZERO, films: None });
    // A picture that is one strip needs no file.
    let is_filed = t.is_part || t.strips.are_several() || first_row > 0;
    let mut rows = kept_rows(t, &mut checkpoints, first_row, is_filed)?;
    let (mut paths, mut pilot_paths) = (per_row * first_row as u64, 0);
    let progress = Progress::new(asked_for, t.silent);
    let beside = Mutex::new(Beside::new(t, checkpoints, is_filed));
    let tell_start = |paths: u64, pilot_paths: u64| {
        progress.start_at(paths + pilot_paths);
        if is_resumed && !t.silent {
            let samples = paths / (width * height) as u64;
            eprintln!("goes on from {} at {samples} samples a pixel", path.display());
        }
    };
    if saved.is_none() {
        tell_start(paths, 0);
    }
    let patience = Patience::begin();
    for strip in t.strips.from(first_row) {
        let mut film = Film::of_rows(width, strip.clone(), responses.clone());
        let mut pilot =
            settings.noise_target.map(|_| Pilot::new(Film::of_rows(width, strip.clone(), of_sensor.clone())));
        if let Some(saved) = saved.take() {
            saved.fill(&mut film, pilot.as_mut())?;
            tell_start(paths + film.total(), pilot.as_ref().map_or(0, |pilot| pilot.film.total()));
        }
        let before = start.elapsed();
        let step = |step: Step<'_>| match step {
            Step::Band { paths } => {
                progress.advance(paths);
                stop()
            }
            Step::Pass { film, pilot, elapsed, planned_paths } => {
                let elapsed = earlier + before + elapsed;
                // Those of all other strips are known.
                let of_strip = per_row * strip.len() as u64;
                let planned = asked_for - of_strip + planned_paths.unwrap_or(of_strip);
                let traced = paths + film.total();
                let done = traced + pilot.map_or(0, |pilot| pilot.film.total());
                let samples = traced as f64 / (width * height) as f64;
                progress.pass(samples, expected_paths(settings, done, elapsed, planned));
                if settings.time_limit.is_some_and(|limit| elapsed >= limit) {
                    return ControlFlow::Break(());
                }
                // What is done is kept below.
                stop()?;
                beside.lock().expect("nobody panics while holding it").keep(film, pilot, elapsed)
            }
        };
        fill(t, &job, &mut film, pilot.as_mut(), &step);
        let mut beside = beside.lock().expect("nobody panics while holding it");
        if let Some(error) = beside.failure.take() {
            progress.finish();
            return Err(error);
        }
        if stop().is_break() {
            progress.finish();
            return Err(beside.stop(&film, pilot.as_ref(), earlier + start.elapsed()));
        }
        rows.write(&film, t.folder)?;
        beside.finish(&film, earlier + start.elapsed())?;
        if stop().is_break() && !is_filed {
            progress.finish();
            return Err(beside.stop(&film, pilot.as_ref(), earlier + start.elapsed()));
        }
        paths += film.total();
        pilot_paths += pilot.as_ref().map_or(0, |pilot| pilot.film.total());
    }
    progress.finish();
    if patience.end().is_break() {
        return Err(beside.into_inner().expect("nobody panics while holding it").stopped());
    }
    Ok(Traced { rows, paths, pilot_paths, earlier })
}

/// Gives a film its samples; one that has a pilot has all rows.
fn fill(t: &Trace<'_>, job: &RenderJob<'_>, film: &mut Film, pilot: Option<&mut Pilot>, step: &Listener<'_>) {
    match (t.settings.noise_target, pilot) {
        (Some(target), Some(pilot)) => {
            let chain = t.chain;
            let needed = |pilot: &Film| chain.samples_needed(&pilot.estimate(chain.channels()), pilot.counts(), target);
            render_with_pilot(job, film, pilot, &needed, step);
        }
        _ => render_on(job, film, step),
    }
}

/// Where the rows go, those that a checkpoint has included.
fn kept_rows(t: &Trace<'_>, checkpoints: &mut Checkpoints<'_>, first_row: usize, is_filed: bool) -> Result<KeptRows> {
    let [width, height] = pixels(t.capture).map(|n| n as usize);
    let channels = t.responses.len();
    if t.is_part {
        let stored = if first_row == 0 { 0 } else { film_bytes([width, height], channels, first_row) };
        let file = checkpoints.open_rows(stored)?;
        return Ok(KeptRows::Sums { file, path: checkpoints.rows_path().to_owned(), height });
    }
    let with_variance = t.capture.sensor.cfa.channels().len();
    let stored = first_row * width * LightRows::bytes_per_pixel(channels, with_variance);
    let file = is_filed.then(|| checkpoints.open_rows(stored as u64)).transpose()?;
    let store = file.map(|file| -> Box<dyn Store> { Box::new(file) });
    Ok(KeptRows::Light(KeptRows::light(t.capture, t.responses, store)))
}

/// How many paths there will be in all, as far as can be told after a pass that brought them to `done`: those that are
/// planned, or those that fit into the time.
fn expected_paths(settings: &RenderSettings, done: u64, elapsed: Duration, planned: u64) -> u64 {
    let in_time = settings.time_limit.map(|limit| done as f64 * limit.as_secs_f64() / elapsed.as_secs_f64());
    in_time.map_or(planned, |paths| planned.min(paths as u64)).max(done)
}

/// What is written of a render that is under way.
struct Beside<'a> {
    t: &'a Trace<'a>,
    checkpoints: Checkpoints<'a>,
    /// Whether rows that are done lie in a file.
    is_filed: bool,
    preview: Due,
    /// Electron rates as far as they are known, if they are shown.
    seen: Option<Planes>,
    failure: Option<photosite::Error>,
}

impl<'a> Beside<'a> {
    fn new(t: &'a Trace<'a>, checkpoints: Checkpoints<'a>, is_filed: bool) -> Self {
        let interval = t.capture.output.preview_interval;
        let [width, height] = pixels(t.capture).map(|n| n as usize);
        let seen = interval.map(|_| Planes::zeros(width, height, t.chain.channels()));
        Self { t, checkpoints, is_filed, preview: Due::every(interval), seen, failure: None }
    }

    /// Writes what it is time for. What goes wrong is kept, and ends the render.
    fn keep(&mut self, film: &Film, pilot: Option<&Pilot>, elapsed: Duration) -> ControlFlow<()> {
        let written = self.checkpoints.keep(film, pilot, elapsed).and_then(|()| self.show(film));
        match written {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.failure = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    /// Keeps a film that a signal has broken off, and tells of it.
    fn stop(&mut self, film: &Film, pilot: Option<&Pilot>, elapsed: Duration) -> photosite::Error {
        match self.checkpoints.keep_now(film, pilot, elapsed) {
            Ok(()) => self.stopped(),
            Err(error) => error,
        }
    }

    fn stopped(&self) -> photosite::Error {
        let path = self.checkpoints.path();
        stopped(if path.exists() {
            format!("give the same command again, and it goes on from {}", path.display())
        } else {
            "nothing is kept of it, since output.checkpoint_interval_s is 0".to_owned()
        })
    }

    /// The rows of a film are kept.
    fn finish(&mut self, film: &Film, elapsed: Duration) -> Result<()> {
        self.see(film);
        if self.is_filed { self.checkpoints.keep_rows(film.picture_rows().end, elapsed) } else { Ok(()) }
    }

    fn see(&mut self, film: &Film) {
        let first = film.picture_rows().start * film.width();
        let planes = self.seen.iter_mut().flat_map(Planes::channels_mut);
        // The sensor's channels come first.
        for (channel, plane) in planes.enumerate() {
            let means = film.means(channel, 0..film.counts().len());
            plane.data[first..].iter_mut().zip(means).for_each(|(seen, mean)| *seen = mean);
        }
    }

    /// Writes a picture if it is time for one.
    fn show(&mut self, film: &Film) -> Result<()> {
        if !self.preview.is_now() {
            return Ok(());
        }
        let start = Instant::now();
        self.see(film);
        let Some(mean) = self.seen.clone() else { return Ok(()) };
        let chain = self.t.chain;
        // No picture needs the variance.
        let variance = Planes::zeros::<&str>(mean.width(), mean.height(), []);
        // Too little light for an exposure yet is no failure: there is nothing to show.
        let Ok(exposed) = chain.expose(Estimate { mean, variance }, Seconds(1.0), None) else { return Ok(()) };
        let raw = chain.read_out(&exposed, 0)?;
        drop(exposed);
        self.t.folder.write_preview(&chain.develop(&raw)?)?;
        self.preview.done_since(start);
        Ok(())
    }
}
