//! Tracer on a thread of its own: one trace after the other, each of which may pause, stop, or give way to the next.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use tokio::sync::watch;

use super::source::NumberedLight;
use super::status::{CameraState, Phase, Status};
use photosite_capture::Capture;
use photosite_core::locked::locked;
use photosite_core::{Error, Result};
use photosite_pipeline::{Event, FilmMemory, Light, Monitor, Options, Prepared};
use photosite_transport::film::Film;

/// Largest part of the time that publishing a light may take.
const PUBLISHING_PART: f64 = 0.2;
/// Interval at which a thread that waits looks whether it is to stop.
const LOOK_INTERVAL: Duration = Duration::from_millis(20);

/// Monitor of the program from outside.
pub type Outside = Arc<dyn Monitor + Send + Sync>;

/// Orders to the tracer.
#[derive(Default)]
struct Orders {
    /// Trace that is to begin.
    next: Option<Wanted>,
    is_paused: bool,
    is_stopped: bool,
}

/// Trace that is wanted.
#[derive(Clone, Debug, Default)]
pub(super) struct Wanted {
    /// Changes to the capture.
    pub(super) changes: Vec<String>,
    /// The number of the frame, where frames have light of their own.
    pub(super) frame: u32,
}

/// Tracer on a thread of its own.
pub(super) struct Tracer {
    orders: Mutex<Orders>,
    changed: Condvar,
    status: watch::Sender<Status>,
    lit: Mutex<Option<NumberedLight>>,
    /// The newest trace.
    wanted: Mutex<Wanted>,
    /// Number of images that are being made, for which tracing waits.
    images: AtomicUsize,
    outside: Outside,
    film_memory: FilmMemory,
    /// Path of the checkpoint of the capture as it is.
    checkpoint: Option<PathBuf>,
}

impl Tracer {
    pub(super) fn new(
        outside: Outside,
        status: watch::Sender<Status>,
        film_memory: FilmMemory,
        checkpoint: Option<PathBuf>,
    ) -> Arc<Self> {
        status.send_replace(Status::new(Phase::Preparing));
        Arc::new(Self {
            orders: Mutex::default(),
            changed: Condvar::new(),
            status,
            lit: Mutex::new(None),
            wanted: Mutex::default(),
            images: AtomicUsize::new(0),
            outside,
            film_memory,
            checkpoint,
        })
    }

    /// The newest light.
    pub(super) fn lit(&self) -> Option<NumberedLight> {
        locked(&self.lit).clone()
    }

    /// Begins a trace anew.
    pub(super) fn start(&self, wanted: Wanted) {
        *locked(&self.orders) = Orders { next: Some(wanted), ..Orders::default() };
        self.changed.notify_all();
    }

    /// Pauses tracing, or goes on.
    pub(super) fn pause(&self, is_paused: bool) {
        locked(&self.orders).is_paused = is_paused;
        self.status.send_if_modified(|status| {
            let phase = match (status.phase, is_paused) {
                (Phase::Tracing, true) => Phase::Paused,
                (Phase::Paused, false) => Phase::Tracing,
                (other, _) => other,
            };
            std::mem::replace(&mut status.phase, phase) != phase
        });
        self.changed.notify_all();
    }

    /// Ends the trace with what is there, which a checkpoint keeps where there is a folder for it.
    pub(super) fn stop(&self) {
        locked(&self.orders).is_stopped = true;
        self.changed.notify_all();
    }

    /// Guard that keeps tracing waiting until it is dropped.
    pub(super) fn make_way(&self) -> WayMade<'_> {
        self.images.fetch_add(1, Ordering::Relaxed);
        WayMade(self)
    }

    /// Traces what is ordered until the program is asked to end; the error says how the work goes on.
    pub(super) fn run(&self, capture: &Capture) -> Error {
        let mut earlier: Option<Prepared> = None;
        let mut wanted = Wanted::default();
        loop {
            let traced = self.trace(capture, &wanted, &mut earlier);
            match traced {
                Ok(()) => self.status.send_modify(|status| (status.phase, status.left_s) = (Phase::Done, Some(0.0))),
                Err(error @ Error::Cancelled { .. }) if self.outside.is_cancelled() => return error,
                Err(Error::Cancelled { .. }) if locked(&self.orders).next.is_some() => {}
                Err(Error::Cancelled { help, .. }) => self.status.send_modify(|status| {
                    status.phase = Phase::Stopped;
                    status.message = self.checkpoint.as_ref().and(help).map(|help| help.to_string());
                }),
                Err(error) => self.status.send_modify(|status| {
                    status.phase = Phase::Failed;
                    status.message = Some(error.to_string());
                }),
            }
            wanted = self.next();
            locked(&self.wanted).clone_from(&wanted);
        }
    }

    /// Changes to the capture that the newest trace was begun with.
    pub(super) fn changes(&self) -> Vec<String> {
        locked(&self.wanted).changes.clone()
    }

    /// Waits for the next order to trace.
    fn next(&self) -> Wanted {
        let mut orders = locked(&self.orders);
        loop {
            if let Some(wanted) = orders.next.take() {
                return wanted;
            }
            orders = self.changed.wait(orders).unwrap_or_else(std::sync::PoisonError::into_inner);
        }
    }

    fn trace(&self, capture: &Capture, wanted: &Wanted, earlier: &mut Option<Prepared>) -> Result<()> {
        let Wanted { changes, frame } = wanted;
        self.status.send_modify(|status| {
            let camera = status.camera.take();
            *status = Status { trace: status.trace + 1, light: status.light, camera, ..Status::new(Phase::Preparing) };
        });
        let changed = if changes.is_empty() { capture.clone() } else { capture.with(changes)? };
        let first = Prepared::after(earlier.take(), changed)?;
        let moves = first.capture().recording().is_some();
        let prepared = Arc::new(if moves && *frame > 0 { first.at_frame(*frame)? } else { first.clone() });
        *earlier = Some(first);
        self.status.send_modify(|status| {
            status.phase = Phase::Tracing;
            status.warnings = prepared.warnings().to_vec();
            status.camera = CameraState::new(&prepared);
            status.frame = moves.then_some(prepared.frame());
        });
        prepared.warnings().iter().for_each(|warning| self.outside.report(Event::Warning(warning)));
        let job = Job {
            tracer: self,
            prepared: &prepared,
            begun: Instant::now(),
            paths: AtomicU64::new(0),
            rest: Mutex::new(Rest { since: None, spent: Duration::ZERO, published: None }),
        };
        let checkpoint = self.checkpoint.as_deref().filter(|_| changes.is_empty() && prepared.frame() == 0);
        let light = prepared.trace(Options {
            monitor: &job,
            film_memory: self.film_memory,
            checkpoint,
            is_coarse_first: true,
        })?;
        self.publish(light);
        Ok(())
    }

    /// Makes a light the newest.
    fn publish(&self, light: Light) {
        let mut lit = locked(&self.lit);
        self.status.send_modify(|status| {
            status.light += 1;
            let (number, trace) = (status.light, status.trace);
            *lit = Some(NumberedLight { light, number, trace });
        });
    }

    fn is_cancelled(&self) -> bool {
        let orders = locked(&self.orders);
        orders.is_stopped || orders.next.is_some() || self.outside.is_cancelled()
    }
}

/// Guard that keeps tracing waiting while it is there.
pub(super) struct WayMade<'a>(&'a Tracer);

impl Drop for WayMade<'_> {
    fn drop(&mut self) {
        self.0.images.fetch_sub(1, Ordering::Relaxed);
        self.0.changed.notify_all();
    }
}

/// Job of the tracer: one trace, and the progress that it publishes.
struct Job<'a> {
    tracer: &'a Tracer,
    prepared: &'a Arc<Prepared>,
    begun: Instant,
    paths: AtomicU64,
    rest: Mutex<Rest>,
}

/// Times in which nothing is traced, and the last light that was published.
struct Rest {
    since: Option<Instant>,
    spent: Duration,
    /// End of the last publication of light, and the time that it took.
    published: Option<(Instant, Duration)>,
}

impl Job<'_> {
    /// Waits while there is a pause, or an image is being made.
    fn wait(&self) {
        let tracer = self.tracer;
        let mut orders = locked(&tracer.orders);
        while (orders.is_paused || tracer.images.load(Ordering::Relaxed) > 0)
            && !(orders.is_stopped || orders.next.is_some() || tracer.outside.is_cancelled())
        {
            let is_paused = orders.is_paused;
            let waited = tracer.changed.wait_timeout(orders, LOOK_INTERVAL);
            orders = waited.map_or_else(|poisoned| poisoned.into_inner().0, |(orders, _)| orders);
            let mut rest = locked(&self.rest);
            if is_paused && rest.since.is_none() {
                rest.since = Some(Instant::now());
            }
        }
        drop(orders);
        let mut rest = locked(&self.rest);
        if let Some(since) = rest.since.take() {
            rest.spent += since.elapsed();
        }
    }

    /// Seconds without pauses.
    fn elapsed_s(&self) -> f64 {
        self.begun.elapsed().saturating_sub(locked(&self.rest).spent).as_secs_f64()
    }

    /// Publishes what is traced so far, unless that would take too much of the time.
    fn show(&self, film: &Film) {
        let start = Instant::now();
        let last = locked(&self.rest).published;
        // What a trace that is stopped leaves is shown in any case.
        let is_last = locked(&self.tracer.orders).is_stopped;
        if !is_last
            && last.is_some_and(|(end, took)| {
                start.duration_since(end).as_secs_f64() * PUBLISHING_PART < took.as_secs_f64()
            })
        {
            return;
        }
        // An image that is traced in strips shows when it is whole.
        if let Ok(Some(light)) = self.prepared.light_so_far(film, self.elapsed_s()) {
            self.tracer.publish(light);
        }
        locked(&self.rest).published = Some((Instant::now(), start.elapsed()));
    }

    fn tell(&self, change: impl FnOnce(&mut Status)) {
        let (elapsed_s, paths) = (self.elapsed_s(), self.paths.load(Ordering::Relaxed));
        self.tracer.status.send_modify(|status| {
            (status.elapsed_s, status.paths) = (elapsed_s, paths);
            change(status);
            let left = status.expected_paths.saturating_sub(paths) as f64;
            status.left_s = (paths > 0).then(|| left * elapsed_s / paths as f64);
        });
    }
}

impl Monitor for Job<'_> {
    fn report(&self, event: Event<'_>) {
        match event {
            Event::TraceBegins { traced, expected, samples_per_pixel, .. } => {
                self.paths.store(traced, Ordering::Relaxed);
                self.tell(|status| {
                    (status.expected_paths, status.samples_per_pixel) = (expected, samples_per_pixel as f64);
                });
            }
            Event::Traced(paths) => {
                self.paths.fetch_add(paths, Ordering::Relaxed);
                self.tell(|_| {});
                self.wait();
            }
            Event::PassEnds { samples_per_pixel, expected, film } => {
                self.tell(|status| (status.expected_paths, status.samples_per_pixel) = (expected, samples_per_pixel));
                self.show(film);
            }
            Event::Warning(words) => self.tell(|status| status.warnings.push(words.to_owned())),
            Event::TraceEnds
            | Event::SetBegins { .. }
            | Event::ImageFails { .. }
            | Event::ImageEnds(_)
            | Event::Waiting { .. }
            | Event::SetEnds => {}
        }
        self.tracer.outside.report(event);
    }

    fn is_cancelled(&self) -> bool {
        self.tracer.is_cancelled()
    }
}
