//! Making the missing images of a data set, next to other processes that do the same.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::DataSet;
use super::folder::DatasetFolder;
use super::frames::Frames;
use super::jobs::Jobs;
use super::outcome::DatasetOutcome;
use super::render_image::FrameImage;
use super::selection::in_order;
use photosite_capture::Capture;
use photosite_core::{Error, Result};
use photosite_pipeline::{Event, LightSource, Monitor, pixels};

/// Options of making a data set's images.
#[derive(Clone, Copy, Debug, Default)]
pub struct MakeOptions {
    /// Whether an image that cannot be made is reported and left out.
    pub keeps_going: bool,
    /// Number of images made at once, which share the threads; `None` makes small ones one for each thread, and others
    /// one by one.
    pub jobs: Option<u16>,
    /// Whether warnings about images are left to the reader of their reports, since they hold for some images of a run
    /// alone.
    pub leaves_warnings: bool,
}

/// Whether an image is too small to share among threads: less than some seconds of work for one.
fn is_small(capture: &Capture) -> bool {
    const FEW_PATHS: u64 = 1 << 22;
    let [width, height] = pixels(capture).map(u64::from);
    width * height * u64::from(capture.render().samples_per_pixel) <= FEW_PATHS
        && capture.render().noise_target.is_none()
}

impl DataSet {
    /// Makes all missing images of the frames, with the light that a camera has in a frame.
    pub fn make(
        &self,
        frames: &Frames,
        folder: &DatasetFolder,
        monitor: &dyn Monitor,
        options: MakeOptions,
        light: impl Fn(&str, u32) -> Result<LightSource<'static>> + Sync,
    ) -> Result<DatasetOutcome> {
        self.warn(folder, monitor);
        folder.record_failures(frames, self.plan.cameras().iter().map(|camera| &*camera.place.name));
        let mut todo: Vec<FrameImage<'_>> = self.images(frames).filter(|&(n, c, _)| !folder.is_done(c, n)).collect();
        if !folder.knows_locks() && !todo.is_empty() {
            // Each process begins somewhere else, so that few make the same.
            let somewhere = RandomState::new().hash_one(()) as usize % todo.len();
            todo.rotate_left(somewhere);
        }
        monitor.report(Event::SetBegins { images: todo.len() as u64 });
        let _until_end = UntilSetEnds(monitor);
        let pools = self.pools(options.jobs, todo.len())?;
        let jobs = Jobs {
            set: self,
            folder,
            monitor,
            keeps_going: options.keeps_going,
            light: &light,
            made: Mutex::new(DatasetOutcome { failed: frames.failed.clone(), ..DatasetOutcome::default() }),
            said: Mutex::default(),
            is_over: AtomicBool::new(false),
        };
        let end = jobs.go_on(todo, &pools);
        if !options.leaves_warnings {
            let said = jobs.said.into_inner().unwrap_or_else(PoisonError::into_inner);
            said.in_words().iter().for_each(|words| monitor.report(Event::Warning(words)));
        }
        end?;
        let mut made = jobs.made.into_inner().unwrap_or_else(PoisonError::into_inner);
        made.failed = in_order(made.failed);
        Ok(made)
    }

    /// Number of jobs for this number of images.
    pub(super) fn jobs(&self, jobs: Option<u16>, images: usize) -> usize {
        // On a card one image is traced while another is loaded or written.
        let automatic = || match (self.captures[0].device(), self.captures.iter().all(is_small)) {
            (Some(_), _) => 2,
            (None, true) => rayon::current_num_threads(),
            (None, false) => 1,
        };
        jobs.map_or_else(automatic, usize::from).min(images)
    }

    /// Thread pools, one for each job: a job that waits for a part of its work must not take up another image
    /// meanwhile. A single job has none, and uses all threads.
    fn pools(&self, jobs: Option<u16>, images: usize) -> Result<Vec<ThreadPool>> {
        let threads = rayon::current_num_threads();
        let jobs = self.jobs(jobs, images);
        if jobs <= 1 {
            return Ok(Vec::new());
        }
        let pool = |job: usize| {
            let threads = ((threads + job) / jobs).max(1);
            let pool = ThreadPoolBuilder::new().num_threads(threads).build();
            pool.map_err(|reason| Error::Resources {
                message: format!("cannot start the threads of {jobs} jobs: {reason}"),
                help: Some("ask for fewer at once".into()),
            })
        };
        (0..jobs).map(pool).collect()
    }

    /// Warns of settings that have no effect in a data set, and of file systems without reliable locks.
    fn warn(&self, folder: &DatasetFolder, monitor: &dyn Monitor) {
        if self.captures.iter().any(|capture| capture.sensor().image_lag.is_some()) {
            monitor.report(Event::Warning(
                "the images of a data set are made one by one, maybe by several processes: each starts without the \
                 charge that sensor.charge.image_lag keeps from the frame before",
            ));
        }
        if !folder.knows_locks() {
            monitor.report(Event::Warning(
                "the file system of the data set knows no locks: of processes that fill the folder together two may make \
                 the same image, of which one is dropped",
            ));
        }
    }
}

/// Guard that reports the end of a set whichever way it ends.
struct UntilSetEnds<'a>(&'a dyn Monitor);

impl Drop for UntilSetEnds<'_> {
    fn drop(&mut self) {
        self.0.report(Event::SetEnds);
    }
}
