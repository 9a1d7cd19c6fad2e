//! A data set as work for the schedulers of clusters and farms: how it is cut into tasks, what each asks for, and the
//! files that say so.

mod openjd;
mod shell;
mod slurm;

use std::path::PathBuf;

use serde::Serialize;

pub use openjd::{LONGEST_PARAMETER, template};
use photosite_core::counted;
pub use shell::{all_quoted, quoted};
pub use slurm::{Site, index_command, script};

use crate::dataset::{Forecast, FrameList, duration, size};

/// Of the time that was measured so much is asked for, as other machines may be slower, and what it takes to begin.
const TIME_FACTOR: f64 = 2.0;
const START_S: f64 = 120.0;
/// Of the memory that was measured so much is asked for, in whole steps.
const MEMORY_FACTOR: f64 = 1.5;
const MEMORY_STEP_MIB: u64 = 256;
/// Before the time is over, a task is told to keep what it has so long, s.
const NOTICE_S: u32 = 30;
/// Slurm's limit for arrays, unless it is set otherwise.
const MOST_TASKS: usize = 1000;

/// How somebody wants a data set to be cut.
#[derive(Clone, Copy, Debug)]
pub enum Cut {
    /// Into so many tasks.
    Tasks(u32),
    /// Into tasks that take about so long, s.
    Time(f64),
}

/// What is the same of all tasks.
#[derive(Clone, Debug)]
pub struct Job {
    /// What it is called.
    pub name: String,
    /// The command of photosite: a name or a path.
    pub program: String,
    /// The data set file, wherever the scheduler starts the command.
    pub input: PathBuf,
    /// The folder of the data set.
    pub output: PathBuf,
    /// More arguments of `photosite dataset`, as changes to the capture.
    pub arguments: Vec<String>,
}

/// The tasks of a data set, with what they ask for.
#[derive(Clone, Debug, Serialize)]
pub struct Tasks {
    /// The frames of each.
    #[serde(skip)]
    pub frames: Vec<FrameList>,
    /// How many tasks there are.
    pub tasks: usize,
    /// Most frames of one.
    pub frames_per_task: usize,
    /// Time of the longest as measured, s.
    pub task_s: f64,
    /// Time that each asks for, minutes.
    pub time_limit_min: u64,
    /// Memory that each asks for, MiB; unknown where it could not be measured.
    pub memory_mib: Option<u64>,
    /// Cores that each asks for.
    pub threads: usize,
}

impl Tasks {
    /// Cuts what is missing into tasks of consecutive frames, of nearly equal numbers of them.
    pub fn new(forecast: &Forecast, cut: Cut, time_limit_min: Option<u64>) -> Self {
        let missing = &forecast.missing;
        let count = match cut {
            Cut::Tasks(tasks) => tasks as usize,
            Cut::Time(seconds) => {
                let in_one = (seconds / forecast.frame_s.max(1e-6)).floor().max(1.0);
                ((missing.len() as f64 / in_one).ceil() as usize).min(MOST_TASKS)
            }
        };
        let count = count.clamp(1, missing.len().max(1));
        let share = |i: usize| &missing[i * missing.len() / count..(i + 1) * missing.len() / count];
        let frames_per_task = (0..count).map(|i| share(i).len()).max().unwrap_or(0);
        let task_s = frames_per_task as f64 * forecast.frame_s;
        let asked_min = ((task_s * TIME_FACTOR + START_S) / 60.0).ceil() as u64;
        let memory_mib = forecast.memory_bytes.map(|bytes| {
            let mib = bytes as f64 / f64::from(1 << 20) * MEMORY_FACTOR;
            (mib / MEMORY_STEP_MIB as f64).ceil() as u64 * MEMORY_STEP_MIB
        });
        Self {
            frames: if missing.is_empty() { Vec::new() } else { (0..count).map(|i| FrameList::of(share(i))).collect() },
            tasks: if missing.is_empty() { 0 } else { count },
            frames_per_task,
            task_s,
            time_limit_min: time_limit_min.unwrap_or(asked_min),
            memory_mib,
            threads: forecast.threads,
        }
    }

    /// What was measured, and what is asked for, in sentences.
    pub fn in_words(&self, forecast: &Forecast) -> Vec<String> {
        let Self { tasks, frames_per_task, task_s, time_limit_min, memory_mib, threads, .. } = self;
        let about = if forecast.is_at_most { "at most" } else { "about" };
        let memory = forecast.memory_bytes.map_or_else(|| "an unknown amount".to_owned(), size);
        let asked = memory_mib.map_or_else(
            || "no memory, as it is not known what it takes".to_owned(),
            |mib| format!("{mib} MiB of memory ({MEMORY_FACTOR} times what was measured)"),
        );
        vec![
            format!(
                "frames that lack pictures: {}, each of {}; {} of at most {}",
                forecast.missing.len(),
                counted(forecast.cameras, ["camera", "cameras"]),
                counted(*tasks, ["task", "tasks"]),
                counted(*frames_per_task, ["frame", "frames"])
            ),
            format!(
                "a frame takes {about} {} with {} here, {} at once, and {memory} of memory; all of them take \
                 {} and {} of disk",
                duration(forecast.frame_s),
                counted(*threads, ["thread", "threads"]),
                counted(forecast.jobs, ["picture", "pictures"]),
                duration(forecast.time_s),
                size(forecast.disk_bytes)
            ),
            format!(
                "each task takes {about} {} and asks for {time_limit_min} min (unless told otherwise, for {TIME_FACTOR} times \
                 that and {START_S} s to begin), {} and {asked}",
                duration(*task_s),
                counted(*threads, ["core", "cores"])
            ),
        ]
    }
}
