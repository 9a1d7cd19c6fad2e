//! Forecast of a data set's cost: a few images of each camera are rendered with few samples, and the cost of the rest
//! follows in proportion.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use rayon::ThreadPoolBuilder;
use serde::Serialize;

use super::DataSet;
use super::frames::Frames;
use super::image_folder::{damage, image};
use super::make::MakeOptions;
use super::render_image::{FrameImage, ImageMonitor};
use super::selection::{FrameList, in_order};
use super::warnings_by_kind::WarningsByKind;
use photosite_capture::report::{CheckDepth, Timings};
use photosite_core::locked::locked;
use photosite_core::{Error, Invalid, Result};
use photosite_core::{input, memory, sandbox::trust};
use photosite_pipeline::{Event, LightSource, Monitor, OutputFolder, Rendered, Request, Silent};

/// Least time of tracing from which a speed is estimated, s.
const ENOUGH_S: f64 = 1.0;
/// Number of trial images for each camera: poses differ in what they see, and the first ones are as good as any.
const TRIAL_FRAMES: usize = 3;

/// Forecast of the time and memory that the missing images take on this machine, with this process alone.
#[derive(Clone, Debug, Serialize)]
pub struct Forecast {
    /// Path of the data set file.
    #[serde(skip)]
    input: PathBuf,
    /// Number of images of the selected frames.
    pub pictures: usize,
    /// Number of images that are there.
    pub present: usize,
    /// Frames that cannot be made.
    pub failed: Vec<u32>,
    /// Number of threads that the times are for.
    pub threads: usize,
    /// Number of images made at once.
    pub jobs: usize,
    /// Time for the images of all cameras of a frame, s.
    pub frame_s: f64,
    /// Time for the missing images, s.
    pub time_s: f64,
    /// Whether images may take less, since they end when their noise is low enough.
    pub is_at_most: bool,
    /// Peak memory of the process, bytes; unknown on systems that do not tell.
    pub memory_bytes: Option<u64>,
    /// Disk space for the missing images, bytes.
    pub disk_bytes: u64,
}

impl DataSet {
    /// Checks the keys of every frame, and forecasts the cost of the images missing in the folder at `path`, which is
    /// not changed. With [`MakeOptions::keeps_going`], frames that cannot be made are reported and counted; each of its
    /// jobs has its share of the threads.
    pub fn forecast(
        &self,
        frames: &Frames,
        path: &Path,
        options: MakeOptions,
        monitor: &dyn Monitor,
    ) -> Result<Forecast> {
        let mut forecast = Forecast {
            input: self.file.path().to_owned(),
            pictures: 0,
            present: 0,
            failed: frames.failed.clone(),
            threads: rayon::current_num_threads(),
            jobs: 1,
            frame_s: 0.0,
            time_s: 0.0,
            is_at_most: false,
            memory_bytes: None,
            disk_bytes: 0,
        };
        // Images with their numbers of samples, and not with their captures, which each loads again.
        let mut missing: BTreeMap<&str, Vec<(FrameImage<'_>, u32)>> = BTreeMap::new();
        for one @ (number, camera, changes) in self.images(frames) {
            forecast.pictures += 1;
            // Objects are placed when the image is made.
            match self.described(camera, number, changes) {
                Ok(_) if damage(&image(path, camera, number), CheckDepth::Sizes).is_none() => forecast.present += 1,
                Ok(capture) => {
                    forecast.is_at_most |= capture.render().noise_target.is_some();
                    missing.entry(camera).or_default().push((one, capture.render().samples_per_pixel));
                }
                Err(error) if options.keeps_going => {
                    monitor.report(Event::ImageFails { camera, frame: number, error: &error });
                    forecast.failed.push(number);
                }
                Err(error) => return Err(error),
            }
        }
        forecast.failed = in_order(forecast.failed);
        forecast.jobs = self.jobs(options.jobs, missing.values().map(Vec::len).sum()).max(1);
        self.try_some(&mut forecast, &missing, monitor)?;
        Ok(forecast)
    }

    /// Renders some of the missing images as one of several jobs does, for the forecast of all.
    fn try_some(
        &self,
        forecast: &mut Forecast,
        missing: &BTreeMap<&str, Vec<(FrameImage<'_>, u32)>>,
        monitor: &dyn Monitor,
    ) -> Result<()> {
        let Forecast { threads, jobs, .. } = *forecast;
        let of_one = ThreadPoolBuilder::new().num_threads((threads / jobs).max(1)).build();
        let of_one = of_one.map_err(|reason| Error::Resources {
            message: format!("cannot start {threads} threads: {reason}"),
            help: Some("ask for fewer".into()),
        })?;
        let before = memory::of_process("VmRSS:").unwrap_or(0);
        let said = Mutex::default();
        for missing in missing.values() {
            // The scene is built for the first, and kept.
            of_one.install(|| self.trial(missing[0].0, 1, &said))?;
            // From the middle of equal shares of the set.
            let count = missing.len().min(TRIAL_FRAMES);
            for i in 0..count {
                let (specimen, samples) = missing[(2 * i + 1) * missing.len() / (2 * count)];
                let [time_s, bytes] = of_one.install(|| self.cost(specimen, samples, &said))?;
                let share = missing.len() as f64 / count as f64;
                forecast.frame_s += time_s / (jobs * count) as f64;
                forecast.time_s += time_s / jobs as f64 * share;
                forecast.disk_bytes += (bytes * share) as u64;
            }
        }
        locked(&said).in_words().iter().for_each(|words| monitor.report(Event::Warning(words)));
        // Each job takes what one has taken.
        let of_all = |most: u64| most + (jobs as u64 - 1) * most.saturating_sub(before);
        forecast.memory_bytes = memory::of_process("VmHWM:").map(of_all);
        Ok(())
    }

    /// Seconds and bytes of disk that an image takes with all its samples per pixel.
    fn cost(&self, specimen: FrameImage<'_>, all: u32, said: &Mutex<WarningsByKind>) -> Result<[f64; 2]> {
        let mut few = 1;
        loop {
            let [whole_s, trace_s, bytes] = self.trial(specimen, few, said)?;
            if trace_s >= ENOUGH_S || few == all {
                return Ok([whole_s - trace_s + trace_s / f64::from(few) * f64::from(all), bytes]);
            }
            let enough = f64::from(few) * (1.5 * ENOUGH_S / trace_s.max(1e-3));
            few = all.min(enough.ceil() as u32);
        }
    }

    /// Renders an image with few samples per pixel, and discards it: seconds, those of tracing, and bytes of disk.
    fn trial(
        &self,
        (number, camera, changes): FrameImage<'_>,
        few: u32,
        said: &Mutex<WarningsByKind>,
    ) -> Result<[f64; 3]> {
        locked(said).frame(number);
        let monitor = ImageMonitor { monitor: &Silent, of: (camera, number), said, is_over: &|| false };
        let folder = tempfile::tempdir().map_err(|reason| Error::io(&std::env::temp_dir(), "write into", reason))?;
        trust(folder.path());
        let start = Instant::now();
        let request = Request {
            input: &self.capture_path,
            named: self.file.description.capture.clone(),
            light: LightSource::Traced,
            film_memory: self.film_memory,
            monitor: &monitor,
            is_timed: true,
        };
        let capture =
            self.capture(camera, number, &[changes, &[format!("render.samples_per_pixel={few}")]].concat())?;
        let mut results = OutputFolder::own(folder.path());
        let rendered = self
            .make_ready(camera, capture, &request, Timings::default())
            .and_then(|ready| ready.render_into(&mut results));
        let rendered = rendered.map_err(|error| self.error_of_change(error, camera, number, changes))?;
        let trace_s = match rendered {
            Rendered::Image { timings, .. } => timings.trace_s,
            Rendered::Part(_) => 0.0,
        };
        let files = input::entries(folder.path()).into_iter().flatten().flatten();
        let bytes: u64 = files.filter_map(|entry| entry.metadata().ok()).map(|file| file.len()).sum();
        Ok([start.elapsed().as_secs_f64(), trace_s, bytes as f64])
    }
}

impl Forecast {
    /// Error if some frames cannot be made.
    pub fn check(&self) -> Result<()> {
        if self.failed.is_empty() {
            return Ok(());
        }
        let message = format!("frames cannot be made: {}", FrameList::of(&self.failed));
        Err(Invalid::new("", message).help("see the messages about each").in_file(&self.input))
    }
}

impl fmt::Display for Forecast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pictures, present, time_s, is_at_most, memory_bytes, disk_bytes, .. } = self;
        let about = if *is_at_most { "at most" } else { "about" };
        let (time, disk) = (duration(*time_s), size(*disk_bytes));
        let memory = memory_bytes.map_or("an unknown amount".to_owned(), size);
        write!(
            f,
            "{present} of {pictures} images exist; the others take {about} {time} on this machine, {memory} of \
             memory and {disk} of disk"
        )
    }
}

/// Duration as text: two digits of the unit that fits.
fn duration(seconds: f64) -> String {
    match seconds {
        ..100.0 => format!("{seconds:.1} s"),
        ..6000.0 => format!("{:.0} min", seconds / 60.0),
        ..360_000.0 => format!("{:.1} h", seconds / 3600.0),
        _ => format!("{:.1} days", seconds / 86400.0),
    }
}

/// Number of bytes in MiB, or GiB from 1000 MiB on, as text.
fn size(bytes: u64) -> String {
    let mib = bytes as f64 / f64::from(1 << 20);
    if mib < 1000.0 { format!("{mib:.1} MiB") } else { format!("{:.1} GiB", mib / 1024.0) }
}
