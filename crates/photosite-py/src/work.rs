//! Work without the interpreter's lock: on threads of this process, watched for signals, warnings and progress.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use photosite::pipeline::{Event, Monitor};
use photosite::{Error, Invalid};
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{PYTHON, raise};

/// Time between two looks at signals and progress. Ctrl-C is to be heard within 0.1 s.
const LOOK_INTERVAL: Duration = Duration::from_millis(25);

/// Options of work: threads and progress.
#[derive(Default)]
pub(crate) struct How {
    /// Number of threads; `None` for as many as there are cores.
    pub(crate) threads: Option<usize>,
    /// Callback for progress, called with the work that is done and the whole.
    pub(crate) progress: Option<Py<PyAny>>,
}

/// Watch of work: messages of the threads that work to the one that holds the lock.
#[derive(Default)]
struct Watch {
    done: AtomicU64,
    all: AtomicU64,
    /// Whether images are counted, rather than camera paths.
    of_images: AtomicBool,
    stop: AtomicBool,
    warnings: Mutex<Vec<String>>,
}

impl Monitor for Watch {
    fn report(&self, event: Event<'_>) {
        match event {
            Event::Warning(words) => {
                let mut warnings = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
                if !warnings.iter().any(|known| known == words) {
                    warnings.push(words.to_owned());
                }
            }
            Event::ImageFails { camera, frame, error } => {
                self.report(Event::Warning(&format!("frame {frame} of {camera} is skipped: {error}")));
            }
            Event::SetBegins { images } => {
                self.of_images.store(true, Ordering::Relaxed);
                self.done.store(0, Ordering::Relaxed);
                self.all.store(images, Ordering::Relaxed);
            }
            Event::ImageEnds(_) => {
                self.done.fetch_add(1, Ordering::Relaxed);
            }
            Event::TraceBegins { .. } if self.of_images.load(Ordering::Relaxed) => {}
            Event::TraceBegins { traced, expected, .. } => {
                self.done.store(traced, Ordering::Relaxed);
                self.all.store(expected, Ordering::Relaxed);
            }
            Event::Traced(paths) => {
                self.done.fetch_add(paths, Ordering::Relaxed);
            }
            Event::PassEnds { expected, .. } => self.all.store(expected, Ordering::Relaxed),
            Event::TraceEnds | Event::Waiting { .. } | Event::SetEnds => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Threads that no other work uses: one that waits for a part of its work takes up other work of its pool, and that
/// must not wait for what the first one holds, such as the lock of a folder.
///
/// rayon's own pool would not do, either: a forked child has its locks but not its threads, and would wait for ever.
/// PyTorch's loaders and `multiprocessing` fork by default up to Python 3.13.
struct Threads {
    /// Pool of the threads, until it is given back.
    pool: Option<ThreadPool>,
    count: usize,
    /// Process that the threads run in, by its id.
    process: u32,
}

/// Pools that nobody uses, by the number of their threads.
type FreePools = Vec<(usize, ThreadPool)>;

/// Free pools of a process. Nobody waits for them: in a forked child they may be locked for ever, by a thread of its
/// parent.
static FREE: Mutex<Option<(u32, FreePools)>> = Mutex::new(None);

impl Threads {
    /// Pool of `threads` threads, or of as many as there are cores.
    fn new(threads: Option<usize>) -> photosite::Result<Self> {
        /// Number of threads that is never refused: waiting for each other, they slow down a small machine only a
        /// little.
        const FEW: usize = 256;
        let count = threads.unwrap_or(0);
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let most = FEW.max(4 * cores);
        if count > most {
            let invalid = Invalid::new("threads", format!("at most {most} can be used, got {count}"));
            let help = format!("this machine runs {cores} at once; more would not be faster");
            return Err(invalid.help(help).in_file(Path::new(PYTHON)));
        }
        let process = std::process::id();
        let free = Self::take_free(count, process);
        let pool = free.map_or_else(|| ThreadPoolBuilder::new().num_threads(count).build(), Ok);
        let pool = pool.map_err(|reason| Error::Resources {
            message: format!("cannot start threads: {reason}"),
            help: Some("ask for fewer with threads=".into()),
        })?;
        Ok(Self { pool: Some(pool), count, process })
    }

    fn take_free(count: usize, process: u32) -> Option<ThreadPool> {
        let mut free = FREE.try_lock().ok()?;
        if let Some((_, of_parent)) = free.take_if(|(owner, _)| *owner != process) {
            // Dropping them would wait for threads that are not in this process.
            std::mem::forget(of_parent);
        }
        let (_, pools) = free.as_mut()?;
        let place = pools.iter().position(|(threads, _)| *threads == count)?;
        Some(pools.swap_remove(place).1)
    }

    fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.as_ref().expect("there until it is given back").install(work)
    }
}

impl Drop for Threads {
    fn drop(&mut self) {
        /// Number of pools that are kept for later.
        const KEPT: usize = 4;
        let (Some(pool), Ok(mut free)) = (self.pool.take(), FREE.try_lock()) else { return };
        let (owner, pools) = free.get_or_insert_with(|| (self.process, Vec::new()));
        if *owner == self.process && pools.len() < KEPT {
            pools.push((self.count, pool));
        }
    }
}

/// Does work without the interpreter's lock. Meanwhile the lock is taken some 40 times a second, to see whether a
/// signal has come and to tell of progress; an exception of either stops the work and is raised when it has. Warnings
/// are given at the end, each once.
pub(crate) fn work<T: Send>(
    py: Python<'_>,
    how: How,
    job: impl FnOnce(&dyn Monitor) -> photosite::Result<T> + Send,
) -> PyResult<T> {
    let watch = Watch::default();
    let (outcome, failed) = py.detach(|| {
        std::thread::scope(|scope| -> PyResult<_> {
            let (tell, told) = channel();
            let watch = &watch;
            let threads = how.threads;
            let begun = std::thread::Builder::new().spawn_scoped(scope, move || {
                let work = || Threads::new(threads)?.install(|| job(watch));
                // Nobody hears it where an exception has ended the wait.
                let _ = tell.send(catch_unwind(AssertUnwindSafe(work)));
            });
            begun.map_err(|reason| PyRuntimeError::new_err(format!("cannot start a thread: {reason}")))?;
            let (mut said, mut failed) = (None, None);
            loop {
                match told.recv_timeout(LOOK_INTERVAL) {
                    Ok(outcome) => return Ok((outcome, failed)),
                    Err(RecvTimeoutError::Disconnected) => unreachable!("the thread tells before it ends"),
                    Err(RecvTimeoutError::Timeout) => {}
                }
                if failed.is_none()
                    && let Err(error) = look(watch, how.progress.as_ref(), &mut said)
                {
                    watch.stop.store(true, Ordering::Relaxed);
                    failed = Some(error);
                }
            }
        })
    })?;
    if let Some(error) = failed {
        // Of work that Ctrl-C has stopped the library says how it goes on.
        return Err(match outcome {
            Ok(Err(stopped @ Error::Cancelled { .. })) if error.is_instance_of::<PyKeyboardInterrupt>(py) => {
                raise(py, stopped)
            }
            Ok(_) | Err(_) => error,
        });
    }
    let outcome = outcome.map_err(|panic| {
        let words = panic.downcast_ref::<String>().map(String::as_str);
        let words = words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason is known");
        PyRuntimeError::new_err(format!("this is a bug in photosite, please report it: {words}"))
    })?;
    let value = outcome.map_err(|error| raise(py, error))?;
    if let Some(progress) = &how.progress {
        let all = watch.all.load(Ordering::Relaxed);
        progress.call1(py, (all, all))?;
    }
    warn(py, watch.warnings.into_inner().unwrap_or_else(PoisonError::into_inner))?;
    Ok(value)
}

/// Looks at signals, and tells of progress where there is any.
fn look(watch: &Watch, progress: Option<&Py<PyAny>>, said: &mut Option<[u64; 2]>) -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        let now = [&watch.done, &watch.all].map(|count| count.load(Ordering::Relaxed));
        if let Some(progress) = progress
            && now[1] > 0
            && *said != Some(now)
        {
            progress.call1(py, (now[0].min(now[1]), now[1]))?;
            *said = Some(now);
        }
        Ok(())
    })
}

/// Gives warnings with the file and line of whoever called the package.
pub(crate) fn warn(py: Python<'_>, warnings: Vec<String>) -> PyResult<()> {
    if warnings.is_empty() {
        return Ok(());
    }
    py.import("photosite._errors")?.getattr("warn_all")?.call1((warnings,)).map(|_| ())
}
