//! Tracing with everything that goes on beside it: progress, images of the state so far, checkpoints, limits of time
//! and noise.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use photosite_capture::Capture;
use photosite_capture::report::PlanReport;
use photosite_core::fail_point;
use photosite_core::image::{Estimate, Planes};
use photosite_core::units::Seconds;
use photosite_core::{Error, Result};
use photosite_files::film_file::film_bytes;
use photosite_files::light_rows::{LightRows, Store};
use photosite_transport::film::{Film, FilmResponses};
use photosite_transport::integrator::{
    Listener, LoadedDevice, Pilot, Plan, RenderJob, RenderSettings, SensorNoise, Step, plan, render_coarse, render_on,
    render_with_pilot,
};
use photosite_transport::optics::Camera;
use photosite_transport::scene::Scene;

use super::completed_rows::CompletedRows;
use crate::camera::capture_camera::pixels;
use crate::monitor::{Event, Monitor, UntilTraceEnds, cancelled};
use crate::prepare::prepared::Prepared;
use crate::prepare::strips::Strips;
use crate::write::checkpoint::{Checkpoints, Resumed};
use crate::write::output_folder::OutputFolder;
use crate::write::throttle::Throttle;

/// Inputs of tracing.
pub(crate) struct Trace<'a> {
    pub(crate) prepared: &'a Prepared,
    /// Job of the image, whose sums are kept where it is a part of a render.
    pub(crate) job: RenderJob<'a>,
    pub(crate) strips: &'a Strips,
    /// Whether a coarse image comes first.
    pub(crate) is_coarse_first: bool,
    /// Folder for previews and for files of rows. Without, everything stays in memory.
    pub(crate) folder: Option<&'a OutputFolder>,
    pub(crate) monitor: &'a dyn Monitor,
}

impl<'a> Trace<'a> {
    fn capture(&self) -> &'a Capture {
        &self.prepared.capture
    }

    fn is_part(&self) -> bool {
        self.job.settings.part.is_some()
    }
}

impl Prepared {
    /// Render job of an image of a scene, which may have moved on since the first image, by the capture's settings with
    /// a seed for its frame.
    pub(crate) fn job<'a>(
        &'a self,
        scene: &'a Scene,
        camera: &'a Camera,
        settings: &'a RenderSettings,
    ) -> RenderJob<'a> {
        let job = RenderJob {
            scene,
            camera,
            transmittance: &self.capture.lens().transmittance,
            responses: &self.responses,
            filters: self.filters.as_ref(),
            importance: None,
            device: None,
            resolution: pixels(&self.capture),
            settings,
        };
        // Frames of one scene and sensor share it.
        let known = std::ptr::eq(scene, &raw const *self.scene).then_some(&self.importance_for_all);
        RenderJob { importance: known.map(|known| known.get_or_init(|| job.importance_for_all())), ..job }
    }
}

/// Light that was traced.
pub(crate) struct Traced {
    pub(crate) rows: CompletedRows,
    /// Number of paths of the image.
    pub(crate) paths: u64,
    /// Number of paths beside those of the image, which found how many the image needs.
    pub(crate) pilot_paths: u64,
    /// Plan that was followed.
    pub(crate) plan: Option<PlanReport>,
    /// Time that was spent on the light before a checkpoint.
    pub(crate) earlier: Duration,
}

/// Traces until the samples, the time or the noise that was asked for is reached, from the last checkpoint on, one
/// strip after the other. A monitor that cancels it ends it with a checkpoint.
pub(crate) fn trace(t: &Trace<'_>, mut checkpoints: Option<Checkpoints<'_>>) -> Result<Traced> {
    let start = Instant::now();
    let settings = t.job.settings;
    let device = t.capture().device().map(|device| LoadedDevice::new(&**device, t.job.scene, settings)).transpose();
    let device = device.map_err(|invalid| t.capture().source().error(invalid))?;
    let job = &RenderJob { device: device.as_ref(), ..t.job };
    let [width, height] = job.resolution.map(|n| n as usize);
    let responses = FilmResponses::new(job.responses);
    // The sensor's channels come first.
    let of_sensor = FilmResponses::new(&job.responses[..t.capture().sensor().cfa.channels().len()]);
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
    // An image that is one strip needs no file.
    let is_filed = checkpoints.is_some() && (t.is_part() || strips.are_several());
    let mut rows = completed_rows(t, checkpoints.as_mut(), first_row, is_filed)?;
    let noise = |light: &Planes| t.prepared.chain().noise_variance(light);
    let noise = settings.noise_target.map(|_| &noise as &SensorNoise<'_>);
    // Of the strategies devices have the plain one, in which there is nothing to choose.
    let find_plan = |step: &Listener<'_>| if device.is_some() { None } else { plan(job, &of_sensor, noise, step) };
    let mut planned: Option<Option<Plan>> = None;
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
                if settings.time_limit().is_some_and(|limit| elapsed >= limit) {
                    return ControlFlow::Break(());
                }
                // What is done is kept below.
                stop()?;
                let kept = interim.lock().expect("nobody panics while holding it").keep(film, pilot, elapsed);
                fail_point::reach("pass-ended");
                kept
            }
        };
        // A limit of time has none to spare for what is not kept.
        if t.is_coarse_first && settings.time_limit_s.is_none() {
            render_coarse(job, &mut film, &step);
        }
        let plan = *planned.get_or_insert_with(|| find_plan(&step));
        // A plan that was broken off is none to go on by.
        if stop().is_break() {
            let mut interim = interim.lock().expect("nobody panics while holding it");
            return Err(interim.stop(&film, pilot.as_ref(), earlier + start.elapsed()));
        }
        let by_plan = plan.map_or_else(|| settings.clone(), |plan| plan.settings(settings));
        fill(t, &RenderJob { settings: &by_plan, ..*job }, &mut film, pilot.as_mut(), &step);
        let mut interim = interim.lock().expect("nobody panics while holding it");
        if let Some(error) = interim.failure.take() {
            return Err(error);
        }
        if let Some(words) = device.as_ref().and_then(LoadedDevice::failure) {
            return Err(interim.break_down(&film, pilot.as_ref(), earlier + start.elapsed(), &words));
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
    // A render that was complete when it went on has followed the same plan.
    let plan = planned.unwrap_or_else(|| find_plan(&|_| ControlFlow::Continue(())));
    Ok(Traced { rows, paths, pilot_paths, plan: plan.map(PlanReport::from), earlier })
}

/// Gives a film its samples; one that has a pilot has all rows.
fn fill(t: &Trace<'_>, job: &RenderJob<'_>, film: &mut Film, pilot: Option<&mut Pilot>, step: &Listener<'_>) {
    match (t.job.settings.noise_target, pilot) {
        (Some(target), Some(pilot)) => {
            let chain = t.prepared.chain();
            let needed = |pilot: &Film| chain.samples_needed(&pilot.estimate(chain.channels()), pilot.counts(), target);
            render_with_pilot(job, film, pilot, &needed, step);
        }
        _ => render_on(job, film, step),
    }
}

/// Place of the completed rows, with those that a checkpoint has included.
fn completed_rows(
    t: &Trace<'_>,
    checkpoints: Option<&mut Checkpoints<'_>>,
    first_row: usize,
    is_filed: bool,
) -> Result<CompletedRows> {
    let [_, height] = pixels(t.capture()).map(|n| n as usize);
    let Some(checkpoints) = checkpoints.filter(|_| is_filed) else {
        return Ok(CompletedRows::Light(CompletedRows::light(t.capture(), t.job.responses, None), None));
    };
    let path = checkpoints.rows_path().to_owned();
    let file = checkpoints.open_rows(first_row, rows_bytes(t))?;
    if t.is_part() {
        return Ok(CompletedRows::Sums { file, path, height });
    }
    let store: Box<dyn Store> = Box::new(file);
    Ok(CompletedRows::Light(CompletedRows::light(t.capture(), t.job.responses, Some(store)), Some(path)))
}

/// The length of the file of completed rows when all rows before one are.
fn rows_bytes(t: &Trace<'_>) -> impl Fn(usize) -> u64 + Send + use<> {
    let size @ [width, _] = pixels(t.capture()).map(|n| n as usize);
    let (is_part, channels) = (t.is_part(), t.job.responses.len());
    let of_light = LightRows::bytes_per_pixel(channels, t.capture().sensor().cfa.channels().len());
    move |row| match (is_part, row) {
        (_, 0) => 0,
        (true, _) => film_bytes(size, channels, row),
        (false, _) => (row * width * of_light) as u64,
    }
}

/// Number of paths that there will be in all, as far as is known after a pass that brought them to `done`: those that
/// are planned, or those that fit into the time.
fn expected_paths(settings: &RenderSettings, done: u64, elapsed: Duration, planned: u64) -> u64 {
    let in_time = settings.time_limit().map(|limit| done as f64 * limit.as_secs_f64() / elapsed.as_secs_f64());
    in_time.map_or(planned, |paths| planned.min(paths as u64)).max(done)
}

/// Interim files of a render under way: checkpoints and previews.
struct Interim<'a> {
    t: &'a Trace<'a>,
    checkpoints: Option<Checkpoints<'a>>,
    /// Whether completed rows lie in a file.
    is_filed: bool,
    preview: Throttle,
    /// Electron rates as far as they are known, if they are shown.
    seen: Option<Planes>,
    /// Whether a warning has said that something could not be written.
    is_said: bool,
    failure: Option<Error>,
}

impl<'a> Interim<'a> {
    fn new(t: &'a Trace<'a>, checkpoints: Option<Checkpoints<'a>>, is_filed: bool) -> Self {
        let preview = Throttle::every(t.folder.and(t.capture().output().preview_interval));
        let [width, height] = pixels(t.capture()).map(|n| n as usize);
        let seen = (!preview.is_never()).then(|| Planes::zeros(width, height, t.prepared.chain().channels()));
        Self { t, checkpoints, is_filed, preview, seen, is_said: false, failure: None }
    }

    /// Writes the files that are due. A failure to write is reported once, as the render needs none of them; where its
    /// folder is gone or the image cannot be made, the error is kept, and ends the render.
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

    /// Keeps a film whose device has stopped.
    fn break_down(&mut self, film: &Film, pilot: Option<&Pilot>, elapsed: Duration, words: &str) -> Error {
        let name = self.t.capture().device().map_or_else(String::new, |device| device.name());
        let stopped = self.stop(film, pilot, elapsed);
        let Error::Cancelled { help, .. } = stopped else { return stopped };
        Error::Temporary(Box::new(Error::Resources { message: format!("{name} has stopped: {words}"), help }))
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

    /// Keeps the rows of a film that is complete.
    fn finish(&mut self, film: &Film, elapsed: Duration) -> Result<()> {
        self.see(film);
        match self.checkpoints.as_mut().filter(|_| self.is_filed) {
            Some(checkpoints) => checkpoints.keep_rows(film.image_rows().end, elapsed),
            None => Ok(()),
        }
    }

    fn see(&mut self, film: &Film) {
        let first = film.image_rows().start * film.width();
        let planes = self.seen.iter_mut().flat_map(Planes::channels_mut);
        // The sensor's channels come first.
        for (channel, plane) in planes.enumerate() {
            let means = film.means(channel, 0..film.counts().len());
            plane.data[first..].iter_mut().zip(means).for_each(|(seen, mean)| *seen = mean);
        }
    }

    /// Writes a preview of the image where one is due.
    fn show(&mut self, film: &Film) -> Result<()> {
        let Some(folder) = self.t.folder.filter(|_| self.preview.is_now()) else { return Ok(()) };
        let start = Instant::now();
        self.see(film);
        let Some(mean) = self.seen.clone() else { return Ok(()) };
        let chain = self.t.prepared.chain();
        // No image needs the variance.
        let variance = Planes::zeros::<&str>(mean.width(), mean.height(), []);
        // Too little light for an exposure yet is no failure: there is nothing to show.
        let Ok(exposed) = chain.expose(Estimate { mean, variance }, Seconds(1.0), None) else { return Ok(()) };
        let raw = chain.read_out(&exposed, 0)?;
        drop(exposed);
        let written = folder.write_preview(&chain.develop_with(&raw, chain.settings.develop)?.0);
        self.preview.done_since(start);
        written
    }
}
