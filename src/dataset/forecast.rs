//! What a data set will take: some pictures of each camera are made with few samples, and the rest follows in proportion.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::iter::Sum;
use std::ops::Add;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::ThreadPoolBuilder;
use serde::Serialize;

use super::DataSet;
use super::frames::Frames;
use super::make::MakeOptions;
use super::picture::OfOnePicture;
use super::presence::{damage, picture};
use super::said::SaidOfPictures;
use super::selection::{FrameList, in_order};
use crate::pipeline::{Event, LightSource, Monitor, OutputFolder, Rendered, Request, Silent};
use crate::report::{Look, Timings};
use crate::{Error, Invalid, Result};
use photosite_core::{input, sandbox::trust};

/// Tracing for less than this says little of the speed, s.
const ENOUGH_S: f64 = 1.0;
/// How many pictures of each camera are made: poses differ in what they see, and the first one is as good as any other.
const SPECIMENS: usize = 3;

/// What the pictures that are missing will take, on this machine with this process alone.
#[derive(Clone, Debug, Serialize)]
pub struct Forecast {
    /// The data set file.
    #[serde(skip)]
    input: PathBuf,
    /// Pictures of the frames that are asked for.
    pub pictures: usize,
    /// Those of them that are there.
    pub present: usize,
    /// Frames that cannot be made.
    pub failed: Vec<u32>,
    /// Frames that lack a picture which can be made.
    #[serde(skip)]
    pub missing: Vec<u32>,
    /// How many cameras take each frame.
    #[serde(skip)]
    pub cameras: usize,
    /// Threads by which times are those.
    pub threads: usize,
    /// How many pictures these make at once.
    pub jobs: usize,
    /// Time for the pictures of all cameras of a frame, s.
    pub frame_s: f64,
    /// Time for the others, s.
    pub time_s: f64,
    /// Whether pictures may take less: they end when their noise is low enough.
    pub is_at_most: bool,
    /// Most memory of the process, bytes; unknown on systems that do not tell.
    pub memory_bytes: Option<u64>,
    /// Disk for the others, bytes.
    pub disk_bytes: u64,
}

impl DataSet {
    /// Checks the keys of every frame, and tells what it takes to make the pictures that are missing in the folder at
    /// `path`, of which nothing is changed. With [`MakeOptions::keeps_going`] frames that cannot be made are reported and counted,
    /// and of its jobs each has its share of the threads.
    pub fn forecast(
        &self,
        frames: &Frames,
        path: &Path,
        options: MakeOptions,
        monitor: &dyn Monitor,
    ) -> Result<Forecast> {
        let mut failed = frames.failed.clone();
        let (mut pictures, mut present) = (0, 0);
        let mut missing: BTreeMap<&str, Vec<Missing<'_>>> = BTreeMap::new();
        let mut is_at_most = false;
        for (number, camera, changes) in self.pictures(frames) {
            pictures += 1;
            // Objects are placed when the picture is made.
            match self.described(camera, number, changes) {
                Ok(_) if damage(&picture(path, camera, number), Look::Sizes).is_none() => present += 1,
                Ok(capture) => {
                    is_at_most |= capture.render.noise_target.is_some();
                    // Not the capture itself, which the picture will load again.
                    let samples = capture.render.samples_per_pixel;
                    missing.entry(camera).or_default().push(Missing { number, changes, samples });
                }
                Err(error) if options.keeps_going => {
                    monitor.report(Event::PictureFails { camera, frame: number, error: &error });
                    failed.push(number);
                }
                Err(error) => return Err(error),
            }
        }
        let jobs = self.jobs(options.jobs, missing.values().map(Vec::len).sum()).max(1);
        let threads = rayon::current_num_threads();
        let of_one = ThreadPoolBuilder::new().num_threads((threads / jobs).max(1)).build();
        let of_one = of_one.map_err(|reason| Error::Resources {
            message: format!("cannot start {threads} threads: {reason}"),
            help: Some("ask for fewer".into()),
        })?;
        let before_bytes = memory_bytes("VmRSS:");
        let mut costs = Cost::default();
        let mut frame_s = 0.0;
        let said = Mutex::default();
        for (camera, missing) in &missing {
            // The scene is built for the first, and kept.
            of_one.install(|| self.trial(camera, &missing[0], 1, &said))?;
            // From the middle of equal shares of the set.
            let count = missing.len().min(SPECIMENS);
            let specimens = (0..count).map(|i| &missing[(2 * i + 1) * missing.len() / (2 * count)]);
            let of_some =
                specimens.map(|one| of_one.install(|| self.cost(camera, one, &said))).sum::<Result<Cost>>()?;
            let share = missing.len() as f64 / count as f64;
            let time_s = of_some.time_s / jobs as f64;
            frame_s += time_s / count as f64;
            costs = costs + Cost { time_s: time_s * share, disk_bytes: of_some.disk_bytes * share };
        }
        let said = said.into_inner().unwrap_or_else(PoisonError::into_inner);
        said.in_words().iter().for_each(|words| monitor.report(Event::Warning(words)));
        // Each job takes what one has taken.
        let most_bytes = memory_bytes("VmHWM:");
        let numbers = missing.values().flatten().map(|one| one.number).collect();
        Ok(Forecast {
            input: self.file.path().to_owned(),
            pictures,
            present,
            failed: in_order(failed),
            missing: in_order(numbers),
            cameras: self.cameras().count(),
            threads,
            jobs,
            frame_s,
            time_s: costs.time_s,
            is_at_most,
            memory_bytes: most_bytes
                .map(|most| most + (jobs as u64 - 1) * most.saturating_sub(before_bytes.unwrap_or(0))),
            disk_bytes: costs.disk_bytes as u64,
        })
    }

    /// What a picture of so many samples a pixel takes.
    fn cost(&self, camera: &str, picture: &Missing<'_>, said: &Mutex<SaidOfPictures>) -> Result<Cost> {
        let all = picture.samples;
        let mut few = 1;
        loop {
            let Trial { whole_s, trace_s, disk_bytes } = self.trial(camera, picture, few, said)?;
            if trace_s >= ENOUGH_S || few == all {
                let time_s = whole_s - trace_s + trace_s / f64::from(few) * f64::from(all);
                return Ok(Cost { time_s, disk_bytes });
            }
            let enough = f64::from(few) * (1.5 * ENOUGH_S / trace_s.max(1e-3));
            few = all.min(enough.ceil() as u32);
        }
    }

    /// Makes a picture of so few samples a pixel, and lets it go.
    fn trial(
        &self,
        camera: &str,
        &Missing { number, changes, .. }: &Missing<'_>,
        few: u32,
        said: &Mutex<SaidOfPictures>,
    ) -> Result<Trial> {
        said.lock().unwrap_or_else(PoisonError::into_inner).frame(number);
        let monitor = OfOnePicture { monitor: &Silent, of: (camera, number), said, is_over: &|| false };
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
        let mut capture = self.capture(camera, number, changes)?;
        (capture.render.samples_per_pixel, capture.render.noise_target) = (few, None);
        let mut results = OutputFolder::own(folder.path());
        let rendered = self
            .make_ready(camera, capture, &request, Timings::default())
            .and_then(|ready| ready.render_into(&mut results));
        let rendered = rendered.map_err(|error| self.error_of_change(error, camera, number, changes))?;
        let trace_s = match rendered {
            Rendered::Picture { timings, .. } => timings.trace_s,
            Rendered::Part(_) => 0.0,
        };
        Ok(Trial { whole_s: start.elapsed().as_secs_f64(), trace_s, disk_bytes: bytes_in(folder.path()) })
    }
}

impl Forecast {
    /// Refuses to call a data set good of which frames cannot be made.
    pub fn check(&self) -> Result<()> {
        if self.failed.is_empty() {
            return Ok(());
        }
        let message = format!("frames cannot be made: {}", FrameList::of(&self.failed));
        Err(Invalid::new("", message).help("see the messages about each").in_file(&self.input))
    }
}

/// A picture that is to be made.
struct Missing<'a> {
    number: u32,
    changes: &'a [String],
    /// Samples of each pixel.
    samples: u32,
}

/// A picture of few samples.
struct Trial {
    whole_s: f64,
    trace_s: f64,
    disk_bytes: f64,
}

/// What pictures take.
#[derive(Default)]
struct Cost {
    time_s: f64,
    disk_bytes: f64,
}

impl Add for Cost {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { time_s: self.time_s + other.time_s, disk_bytes: self.disk_bytes + other.disk_bytes }
    }
}

impl Sum for Cost {
    fn sum<I: Iterator<Item = Self>>(costs: I) -> Self {
        costs.fold(Self::default(), Self::add)
    }
}

fn bytes_in(folder: &Path) -> f64 {
    let entries = input::entries(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.metadata().ok()).map(|file| file.len() as f64).sum()
}

/// The memory of this process, or the most that it has had, as Linux tells it.
fn memory_bytes(key: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let kib: u64 =
        status.lines().find_map(|line| line.strip_prefix(key))?.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib << 10)
}

impl fmt::Display for Forecast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pictures, present, time_s, is_at_most, memory_bytes, disk_bytes, .. } = self;
        let about = if *is_at_most { "at most" } else { "about" };
        let (time, disk) = (duration(*time_s), size(*disk_bytes));
        let memory = memory_bytes.map_or("an unknown amount".to_owned(), size);
        write!(
            f,
            "{present} of {pictures} pictures exist; the others take {about} {time} on this machine, {memory} of \
             memory and {disk} of disk"
        )
    }
}

/// Two digits of the unit that fits.
pub fn duration(seconds: f64) -> String {
    match seconds {
        ..100.0 => format!("{seconds:.1} s"),
        ..6000.0 => format!("{:.0} min", seconds / 60.0),
        ..360_000.0 => format!("{:.1} h", seconds / 3600.0),
        _ => format!("{:.1} days", seconds / 86400.0),
    }
}

/// The same of bytes.
pub fn size(bytes: u64) -> String {
    let mib = bytes as f64 / f64::from(1 << 20);
    if mib < 1000.0 { format!("{mib:.1} MiB") } else { format!("{:.1} GiB", mib / 1024.0) }
}
