//! Several images at once: each job makes one after the other, on threads of its own.
//!
//! An image is on disk once it has its number, which takes longer than to render a small one. So each job leaves that
//! to another thread, and renders the next image meanwhile.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, sleep};
use std::time::{Duration, Instant};

use rayon::ThreadPool;

use super::DataSet;
use super::folder::{DatasetFolder, NewImage, Turn};
use super::outcome::DatasetOutcome;
use super::render_image::{FrameImage, ImageMonitor};
use super::warnings_by_kind::WarningsByKind;
use photosite_capture::report::Timings;
use photosite_core::locked::locked;
use photosite_core::{Error, Result};
use photosite_pipeline::{Event, ImageOfFrame, LightSource, MadeIn, Monitor, go_on};

/// Pauses between two looks at the images of other processes: the first, and the longest.
const SHORTEST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// State shared by all jobs.
pub(super) struct Jobs<'a> {
    pub(super) set: &'a DataSet,
    pub(super) folder: &'a DatasetFolder,
    pub(super) monitor: &'a dyn Monitor,
    pub(super) keeps_going: bool,
    pub(super) light: &'a (dyn Fn(&str, u32) -> Result<LightSource<'static>> + Sync),
    pub(super) made: Mutex<DatasetOutcome>,
    /// Warnings about images, reported at the end.
    pub(super) said: Mutex<WarningsByKind>,
    /// Whether an error has ended the work.
    pub(super) is_over: AtomicBool,
}

/// Image that is rendered and has no number yet.
struct Rendered<'a> {
    of: FrameImage<'a>,
    image: NewImage,
    begun: Instant,
    steps: Timings,
}

impl Jobs<'_> {
    /// Makes images until all are there. Images that other processes make are looked at again at the end, since these
    /// may die.
    pub(super) fn go_on(&self, mut todo: Vec<FrameImage<'_>>, pools: &[ThreadPool]) -> Result<()> {
        let mut pause = SHORTEST_PAUSE;
        while !todo.is_empty() {
            todo = self.go_through(todo, pools)?;
            if !todo.is_empty() {
                if pause == SHORTEST_PAUSE {
                    self.monitor.report(Event::Waiting { images: todo.len() });
                }
                go_on(self.monitor)?;
                sleep(pause);
                pause = LONGEST_PAUSE.min(pause * 2);
            }
        }
        Ok(())
    }

    /// Makes images, one job for each pool, or one on the threads of the caller; returns those that other processes are
    /// making.
    fn go_through<'a>(&self, todo: Vec<FrameImage<'a>>, pools: &[ThreadPool]) -> Result<Vec<FrameImage<'a>>> {
        let queue = Mutex::new(todo.into_iter());
        let theirs = Mutex::new(Vec::new());
        let job = || self.job(&queue, &theirs);
        if pools.is_empty() {
            job()?;
        } else {
            thread::scope(|scope| {
                let jobs: Vec<_> = pools.iter().map(|pool| scope.spawn(|| pool.install(job))).collect();
                // All are waited for, and what the first has to say counts, unless it only stopped for another's error.
                let ends: Vec<Result<()>> = jobs.into_iter().map(joined).collect();
                let (stopped, failed) = ends.into_iter().filter_map(Result::err).partition::<Vec<_>, _>(is_stopped);
                failed.into_iter().chain(stopped).next().map_or(Ok(()), Err)
            })?;
        }
        let mut theirs = theirs.into_inner().unwrap_or_else(PoisonError::into_inner);
        theirs.sort_unstable_by_key(|&(number, camera, _)| (number, camera));
        Ok(theirs)
    }

    /// Takes images out of the queue until it is empty or the work is over.
    fn job<'a>(
        &self,
        queue: &Mutex<std::vec::IntoIter<FrameImage<'a>>>,
        theirs: &Mutex<Vec<FrameImage<'a>>>,
    ) -> Result<()> {
        let end = thread::scope(|scope| {
            let (hand_over, rendered) = sync_channel(0);
            let finisher = scope.spawn(move || self.finish_all(&rendered));
            let made = self.make_all(queue, theirs, &hand_over);
            drop(hand_over);
            // An error of the finisher is why nothing more could be handed over.
            joined(finisher).and(made)
        });
        if end.is_err() {
            self.is_over.store(true, Ordering::Relaxed);
        }
        end
    }

    fn make_all<'a>(
        &self,
        queue: &Mutex<std::vec::IntoIter<FrameImage<'a>>>,
        theirs: &Mutex<Vec<FrameImage<'a>>>,
        hand_over: &SyncSender<Rendered<'a>>,
    ) -> Result<()> {
        let is_over = || self.is_over.load(Ordering::Relaxed);
        while !is_over() {
            let next = locked(queue).next();
            let Some(of @ (number, camera, _)) = next else { break };
            let begun = Instant::now();
            let image = match self.folder.begin(camera, number)? {
                Turn::Theirs => {
                    locked(theirs).push(of);
                    continue;
                }
                Turn::Done => {
                    self.tell(of, None);
                    continue;
                }
                Turn::Ours(image) => image,
            };
            locked(&self.said).frame(number);
            let monitor =
                ImageMonitor { monitor: self.monitor, of: (camera, number), said: &self.said, is_over: &is_over };
            if let Some(lost) = image.lost() {
                monitor.report(Event::Warning(&format!("an image is made again: {lost}")));
            }
            let light = (self.light)(camera, number);
            match light.and_then(|light| self.set.image(of, light, &image, &monitor)) {
                Ok(steps) => {
                    if hand_over.send(Rendered { of, image, begun, steps }).is_err() {
                        break;
                    }
                }
                Err(error) => self.pass_over(of, error)?,
            }
        }
        Ok(())
    }

    fn finish_all(&self, rendered: &Receiver<Rendered<'_>>) -> Result<()> {
        for Rendered { of, image, begun, steps } in rendered {
            match image.finish() {
                Ok(is_ours) => {
                    locked(&self.made).images += usize::from(is_ours);
                    self.tell(of, is_ours.then(|| MadeIn { seconds: begun.elapsed().as_secs_f64(), steps }));
                }
                Err(error) => self.pass_over(of, error)?,
            }
        }
        Ok(())
    }

    /// Skips an image that cannot be made, where the run keeps going.
    fn pass_over(&self, (number, camera, _): FrameImage<'_>, error: Error) -> Result<()> {
        self.folder.record_failure(camera, number, &error);
        if !self.keeps_going || is_stopped(&error) {
            return Err(error);
        }
        go_on(self.monitor)?;
        self.monitor.report(Event::ImageFails { camera, frame: number, error: &error });
        let mut made = locked(&self.made);
        made.failed.push(number);
        made.may_pass |= error.is_temporary();
        drop(made);
        self.monitor.report(Event::ImageEnds(None));
        Ok(())
    }

    fn tell(&self, (frame, camera, _): FrameImage<'_>, made: Option<MadeIn>) {
        self.monitor.report(Event::ImageEnds(Some(ImageOfFrame { camera, frame, made })));
    }
}

fn is_stopped(error: &Error) -> bool {
    matches!(error, Error::Cancelled { .. })
}

/// Result of a thread; its panic goes on in this one.
fn joined<T>(thread: thread::ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
