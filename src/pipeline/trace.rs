//! Tracing with everything that goes on beside it: progress, pictures of the state so far, checkpoints, limits of time
//! and noise.

use std::ops::ControlFlow;
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

use crate::capture::Capture;
use crate::film::{Film, FilmResponses, Response};
use crate::image::{Estimate, Planes};
use crate::integrator::{
    FilterTile, Listener, Pilot, RenderJob, RenderSettings, Step, render_coarse, render_on, render_with_pilot,
};
use crate::io::film_file::film_bytes;
use crate::io::light_rows::{LightRows, Store};
use crate::optics::Camera;
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::units::Seconds;
use crate::{Error, Result};
use photosite_core::fail_point;

use super::camera::pixels;
use super::chain::Chain;
use super::checkpoint::{Checkpoints, Resumed};
use super::completed_rows::CompletedRows;
use super::monitor::{Event, Monitor, UntilTraceEnds, cancelled};
use super::output_folder::OutputFolder;
use super::strips::Strips;
use super::throttle::Throttle;

/// What tracing reads.
pub(super) struct Trace<'a> {
    pub(super) capture: &'a Capture,
    /// Render settings of the capture, with a seed for this frame.
    pub(super) settings: &'a RenderSettings,
    pub(super) scene: &'a Scene,
    pub(super) camera: &'a Camera,
    pub(super) responses: &'a [Response],
    pub(super) filters: Option<&'a FilterTile>,
    pub(super) strips: &'a Strips,
    /// What matters to all pictures of the scene by this sensor, once it is known.
    pub(super) importance: Option<&'a OnceLock<Spectrum>>,
    /// Whether it is a part of a render, of which the sums are kept.
    pub(super) is_part: bool,
    /// Whether a coarse picture comes first.
    pub(super) is_coarse_first: bool,
    pub(super) chain: &'a Chain<'a>,
    /// Where previews go, and whose rows lie in a file. Without, everything stays in memory.
    pub(super) folder: Option<&'a OutputFolder>,
    pub(super) monitor: &'a dyn Monitor,
}

/// Light that was traced.
pub(super) struct Traced {
    pub(super) rows: CompletedRows,
    /// Paths of the picture.
    pub(super) paths: u64,
    /// Paths that are not in it, but found how many are.
    pub(super) pilot_paths: u64,
    /// Time that was spent on it before a checkpoint.
    pub(super) earlier: Duration,
}

/// Traces until the samples, the time or the noise that was asked for is reached, from the last checkpoint on, one
/// strip after the other. A monitor that cancels it ends it with a checkpoint.
pub(super) fn trace(t: &Trace<'_>, mut checkpoints: Option<Checkpoints<'_>>) -> Result<Traced> {
    let start = Instant::now();
    let settings = t.settings;
    let mut job = RenderJob {
        scene: t.scene,
        camera: t.camera,
        transmittance: &t.capture.lens.transmittance,
        responses: t.responses,
        filters: t.filters,
        importance: None,
        resolution: pixels(t.capture),
        settings,
    };
    // Frames of one scene and sensor share it.
    job.importance = t.importance.map(|known| known.get_or_init(|| job.importance_for_all()));
    let [width, height] = job.resolution.map(|n| n as usize);
    let responses = FilmResponses::new(t.responses);
    // The sensor's channels come first.
    let of_sensor = FilmResponses::new(&t.responses[..t.capture.sensor.cfa.channels().len()]);
    let per_row = width as u64 * settings.samples().len() as u64;
    let asked_for = per_row * height as u64;

    let resume = |checkpoints: &Checkpoints<'_>| checkpoints.resume(t.strips, rows_bytes(t));
    let resumed = checkpoints.as_ref().map(resume).transpose()?.flatten();
    let resumed_from = resumed.as_ref().map(|resumed| resumed.path.clone());
    let (begun, earlier, mut saved) = match resumed {
        Some(Resumed { rows, elapsed, films, warning, path: _ }) => {
            warning.iter().for_each(|warning| t.monitor.report(Event::Warning(warning)));
            (rows, elapsed, films)
        }
        None => (0..0, Duration::ZERO, None),
    };
    let first_row = begun.start;
    let strips = t.strips.clone().going_on(begun);
    // A picture that is one strip needs no file.
    let is_filed = checkpoints.is_some() && (t.is_part || strips.are_several());
    let mut rows = completed_rows(t, checkpoints.as_mut(), first_row, is_filed)?;
    let (mut paths, mut pilot_paths) = (per_row * first_row as u64, 0);
    let interim = Mutex::new(Interim::new(t, checkpoints, is_filed));
    let begin = |paths: u64, pilot_paths: u64| {
        t.monitor.report(Event::TraceBegins {
            traced: paths + pilot_paths,
            expected: asked_for,
            resumed: resumed_from.as_deref(),
            samples_per_pixel: paths / (width * height) as u64,
        });
    };
    let until_end = UntilTraceEnds(t.monitor);
    if saved.is_none() {
        begin(paths, 0);
    }
    let stop = || if t.monitor.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    for strip in strips.from(first_row) {
        // Before memory is taken for the film
        if stop().is_break() {
            return Err(interim.into_inner().expect("nobody panics while holding it").stopped());
        }
        let mut film = Film::of_rows(width, strip.clone(), responses.clone());
        let mut pilot =
            settings.noise_target.map(|_| Pilot::new(Film::of_rows(width, strip.clone(), of_sensor.clone())));
        if let Some(saved) = saved.take() {
            saved.fill(&mut film, pilot.as_mut())?;
            begin(paths + film.total(), pilot.as_ref().map_or(0, |pilot| pilot.film.total()));
        }
        let before = start.elapsed();
        let step = |step: Step<'_>| match step {
            Step::Band { paths } => {
                t.monitor.report(Event::Traced(paths));
                stop()
            }
            Step::Coarse { film } => {
                let samples_per_pixel = film.total() as f64 / (width * height) as f64;
                t.monitor.report(Event::PassEnds { samples_per_pixel, expected: asked_for, film });
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
                let expected = expected_paths(settings, done, elapsed, planned);
                t.monitor.report(Event::PassEnds { samples_per_pixel: samples, expected, film });
                if settings.time_limit.is_some_and(|limit| elapsed >= limit) {
                    return ControlFlow::Break(());
                }
                // What is done is kept below.
                stop()?;
                let kept = interim.lock().expect("nobody panics while holding it").keep(film, pilot, elapsed);
                fail_point::reach("pass-ended");
                kept
            }
        };
        fill(t, &job, &mut film, pilot.as_mut(), &step);
        let mut interim = interim.lock().expect("nobody panics while holding it");
        if let Some(error) = interim.failure.take() {
            return Err(error);
        }
        if stop().is_break() {
            return Err(interim.stop(&film, pilot.as_ref(), earlier + start.elapsed()));
        }
        rows.write(&film)?;
        interim.finish(&film, earlier + start.elapsed())?;
        if stop().is_break() && !is_filed {
            return Err(interim.stop(&film, pilot.as_ref(), earlier + start.elapsed()));
        }
        paths += film.total();
        pilot_paths += pilot.as_ref().map_or(0, |pilot| pilot.film.total());
    }
    drop(until_end);
    if t.monitor.is_cancelled() {
        return Err(interim.into_inner().expect("nobody panics while holding it").stopped());
    }
    Ok(Traced { rows, paths, pilot_paths, earlier })
}

/// Gives a film its samples; one that has a pilot has all rows.
fn fill(t: &Trace<'_>, job: &RenderJob<'_>, film: &mut Film, pilot: Option<&mut Pilot>, step: &Listener<'_>) {
    // A limit of time has none to spare for what is not kept.
    if t.is_coarse_first && t.settings.time_limit.is_none() {
        render_coarse(job, film, step);
    }
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
fn completed_rows(
    t: &Trace<'_>,
    checkpoints: Option<&mut Checkpoints<'_>>,
    first_row: usize,
    is_filed: bool,
) -> Result<CompletedRows> {
    let [_, height] = pixels(t.capture).map(|n| n as usize);
    let Some(checkpoints) = checkpoints.filter(|_| is_filed) else {
        return Ok(CompletedRows::Light(CompletedRows::light(t.capture, t.responses, None), None));
    };
    let path = checkpoints.rows_path().to_owned();
    let file = checkpoints.open_rows(first_row, rows_bytes(t))?;
    if t.is_part {
        return Ok(CompletedRows::Sums { file, path, height });
    }
    let store: Box<dyn Store> = Box::new(file);
    Ok(CompletedRows::Light(CompletedRows::light(t.capture, t.responses, Some(store)), Some(path)))
}

/// The length of the file of completed rows when all rows before one are.
fn rows_bytes(t: &Trace<'_>) -> impl Fn(usize) -> u64 + Send + use<> {
    let size @ [width, _] = pixels(t.capture).map(|n| n as usize);
    let (is_part, channels) = (t.is_part, t.responses.len());
    let of_light = LightRows::bytes_per_pixel(channels, t.capture.sensor.cfa.channels().len());
    move |row| match (is_part, row) {
        (_, 0) => 0,
        (true, _) => film_bytes(size, channels, row),
        (false, _) => (row * width * of_light) as u64,
    }
}

/// How many paths there will be in all, as far as is known after a pass that brought them to `done`: those that are
/// planned, or those that fit into the time.
fn expected_paths(settings: &RenderSettings, done: u64, elapsed: Duration, planned: u64) -> u64 {
    let in_time = settings.time_limit.map(|limit| done as f64 * limit.as_secs_f64() / elapsed.as_secs_f64());
    in_time.map_or(planned, |paths| planned.min(paths as u64)).max(done)
}

/// What is written of a render under way: checkpoints and previews.
struct Interim<'a> {
    t: &'a Trace<'a>,
    checkpoints: Option<Checkpoints<'a>>,
    /// Whether rows that are done lie in a file.
    is_filed: bool,
    preview: Throttle,
    /// Electron rates as far as they are known, if they are shown.
    seen: Option<Planes>,
    /// Whether it was said that something could not be written.
    is_said: bool,
    failure: Option<Error>,
}

impl<'a> Interim<'a> {
    fn new(t: &'a Trace<'a>, checkpoints: Option<Checkpoints<'a>>, is_filed: bool) -> Self {
        let preview = Throttle::every(t.folder.and(t.capture.output.preview_interval));
        let [width, height] = pixels(t.capture).map(|n| n as usize);
        let seen = (!preview.is_never()).then(|| Planes::zeros(width, height, t.chain.channels()));
        Self { t, checkpoints, is_filed, preview, seen, is_said: false, failure: None }
    }

    /// Writes what it is time for. What cannot be written is said once, as the render needs none of it; where its
    /// folder is gone or the picture cannot be made, that is kept, and ends the render.
    fn keep(&mut self, film: &Film, pilot: Option<&Pilot>, elapsed: Duration) -> ControlFlow<()> {
        let kept = self.checkpoints.as_mut().map_or(Ok(()), |checkpoints| checkpoints.keep(film, pilot, elapsed));
        for written in [kept, self.show(film)] {
            let Err(error) = written else { continue };
            let is_gone = self.t.folder.is_some_and(|folder| !folder.path().exists());
            if is_gone || !matches!(error, Error::Io { .. } | Error::Temporary(_)) {
                self.failure = Some(error);
                return ControlFlow::Break(());
            }
            if !std::mem::replace(&mut self.is_said, true) {
                self.t.monitor.report(Event::Warning(&format!("{error}: the render continues without it")));
            }
        }
        ControlFlow::Continue(())
    }

    /// Keeps a film that was broken off, and says how the render goes on.
    fn stop(&mut self, film: &Film, pilot: Option<&Pilot>, elapsed: Duration) -> Error {
        let kept = self.checkpoints.as_mut().map_or(Ok(()), |checkpoints| checkpoints.keep_now(film, pilot, elapsed));
        match kept {
            Ok(()) => self.stopped(),
            Err(error) => error,
        }
    }

    fn stopped(&self) -> Error {
        let help = match &self.checkpoints {
            None => "nothing of it is kept: it has no folder".to_owned(),
            Some(checkpoints) if checkpoints.path().exists() => {
                format!("run the same command again, and it continues from {}", checkpoints.path().display())
            }
            Some(_) => "nothing of it is kept, since output.checkpoint_interval_s is 0".to_owned(),
        };
        cancelled(help)
    }

    /// The rows of a film are kept.
    fn finish(&mut self, film: &Film, elapsed: Duration) -> Result<()> {
        self.see(film);
        match self.checkpoints.as_mut().filter(|_| self.is_filed) {
            Some(checkpoints) => checkpoints.keep_rows(film.picture_rows().end, elapsed),
            None => Ok(()),
        }
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

    /// Writes a preview of the picture where it is time for that.
    fn show(&mut self, film: &Film) -> Result<()> {
        let Some(folder) = self.t.folder.filter(|_| self.preview.is_now()) else { return Ok(()) };
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
        let written = folder.write_preview(&chain.develop(&raw)?);
        self.preview.done_since(start);
        written
    }
}
