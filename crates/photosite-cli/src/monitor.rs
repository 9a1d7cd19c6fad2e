//! Display of work under way: warnings, and progress with rate and time left. On a terminal that is a bar; in a file a
//! line every half minute; with `--log-json` an object at least as often.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use photosite_core::counted;
use serde_json::json;

use super::log::{self, say, warning};
use super::signals;
use photosite_core::locked::locked;
use photosite_pipeline::{Event, ImageOfFrame, Monitor};

/// Interval between two lines of progress in a file.
const LINE_INTERVAL: Duration = Duration::from_secs(30);
/// Template of the progress bar, which fills the rest of 80 columns.
const TEMPLATE: &str = "{elapsed_precise} [{wide_bar}] {percent:>3} %  {msg}  {eta_precise} left";

/// Monitor that informs the user on the terminal, and stops work on a signal.
pub(super) struct TerminalMonitor {
    /// Whether warnings are hidden.
    quiet: bool,
    /// Whether progress is hidden.
    silent: bool,
    progress: Mutex<Option<Progress>>,
    /// Whether progress counts images of a data set, so that the progress of single images is hidden.
    is_of_set: Mutex<bool>,
}

/// Progress of the work.
struct Progress {
    /// Bar, where standard error is a terminal.
    bar: Option<ProgressBar>,
    begun: Instant,
    said: Instant,
    /// Paths or images done before this run began, done by now, and to be done in all.
    before: u64,
    done: u64,
    all: u64,
    /// Unit of the count and state of the work, in words.
    state: String,
}

impl Progress {
    fn new(done: u64, all: u64, state: String) -> Self {
        let bar = (std::io::stderr().is_terminal() && !log::is_json()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(all), ProgressDrawTarget::stderr_with_hz(10));
            if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_position(done);
            bar.set_message(state.clone());
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let now = Instant::now();
        Self { bar, begun: now, said: now, before: done, done, all, state }
    }

    fn advance(&mut self, by: u64) {
        self.done += by;
        match &self.bar {
            Some(bar) => bar.inc(by),
            None if self.said.elapsed() >= LINE_INTERVAL => self.say(),
            None => {}
        }
    }

    /// Seconds since this run began, and the amount done in them.
    fn since(&self) -> (f64, u64) {
        (self.begun.elapsed().as_secs_f64().max(1e-9), self.done.saturating_sub(self.before))
    }

    fn say(&mut self) {
        self.said = Instant::now();
        let (seconds, done) = self.since();
        let left_s = (done > 0).then(|| seconds / done as f64 * self.all.saturating_sub(self.done) as f64);
        let part = self.done as f64 / self.all.max(1) as f64;
        if log::is_json() {
            return log::object(
                "progress",
                json!({ "done": self.done, "all": self.all, "state": self.state, "elapsed_s": seconds, "left_s": left_s }),
            );
        }
        let left = left_s.map_or_else(String::new, |left| format!(", {} left", clock(left)));
        say!("{} {:.0} %, {}{left}", clock(seconds), 100.0 * part, self.state);
    }

    fn update(&mut self, all: u64, state: impl FnOnce(f64, u64) -> String) {
        let (seconds, done) = self.since();
        (self.all, self.state) = (all, state(seconds, done));
        if let Some(bar) = &self.bar {
            bar.set_length(all);
            bar.set_message(self.state.clone());
        }
    }
}

/// Duration as hours, minutes and seconds.
fn clock(seconds: f64) -> String {
    let whole = seconds as u64;
    format!("{:02}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl TerminalMonitor {
    /// Monitor without warnings (`quiet`), or without progress (`json`, unless the log is for programs, too).
    pub(super) fn new(quiet: bool, json: bool) -> Self {
        let silent = quiet || json && !log::is_json();
        Self { quiet, silent, progress: Mutex::new(None), is_of_set: Mutex::new(false) }
    }

    fn begin(&self, done: u64, all: u64, state: String) {
        *locked(&self.progress) = (!self.silent).then(|| Progress::new(done, all, state));
    }

    fn advance(&self, by: u64) {
        if let Some(progress) = &mut *locked(&self.progress) {
            progress.advance(by);
        }
    }

    /// Writes an event of `--log-json` that lines for people omit.
    fn log(&self, event: &str, what: serde_json::Value) {
        if log::is_json() && !self.silent {
            log::object(event, what);
        }
    }
}

impl Monitor for TerminalMonitor {
    fn report(&self, event: Event<'_>) {
        let is_of_set = *locked(&self.is_of_set);
        match event {
            Event::Warning(words) if !self.quiet => warning!("{words}"),
            Event::TraceBegins { traced, expected, resumed, samples_per_pixel } => {
                signals::become_patient();
                if is_of_set {
                    return;
                }
                self.begin(traced, expected, format!("{samples_per_pixel} samples per pixel"));
                self.log("trace_begins", json!({ "paths": expected, "traced": traced, "resumed": resumed }));
                if let Some(checkpoint) = resumed.filter(|_| !self.silent) {
                    say!("continuing from {} at {samples_per_pixel} samples per pixel", checkpoint.display());
                }
            }
            Event::Traced(paths) if !is_of_set => self.advance(paths),
            Event::PassEnds { samples_per_pixel, expected, .. } if !is_of_set => {
                if let Some(progress) = &mut *locked(&self.progress) {
                    progress.update(expected, |seconds, paths| {
                        format!(
                            "{samples_per_pixel:.0} samples per pixel, {:.2} M paths/s",
                            paths as f64 / seconds / 1e6
                        )
                    });
                }
            }
            Event::TraceEnds => {
                signals::become_impatient();
                if !is_of_set {
                    *locked(&self.progress) = None;
                    self.log("trace_ends", json!({}));
                }
            }
            Event::SetBegins { images } => {
                *locked(&self.is_of_set) = true;
                self.begin(0, images, format!("{images} images"));
                self.log("set_begins", json!({ "pictures": images }));
            }
            Event::ImageFails { camera, frame, error } => {
                let camera_name = camera;
                let camera = if camera.is_empty() { String::new() } else { format!(" of {camera}") };
                warning!("frame {frame}{camera} is skipped: {error}");
                self.log(
                    "picture_fails",
                    json!({ "camera": camera_name, "frame": frame, "message": error.to_string() }),
                );
            }
            Event::ImageEnds(of) => {
                self.advance(1);
                let of = of.map(|ImageOfFrame { camera, frame, made }| {
                    json!({ "camera": camera, "frame": frame, "seconds": made.map(|made| made.seconds) })
                });
                self.log("picture_ends", of.unwrap_or_else(|| json!({})));
            }
            Event::Waiting { images } if !self.quiet => {
                say!("waiting for {} that other processes are making", counted(images, ["image", "images"]));
            }
            Event::SetEnds => {
                *locked(&self.is_of_set) = false;
                *locked(&self.progress) = None;
                self.log("set_ends", json!({}));
            }
            Event::Warning(_) | Event::Waiting { .. } | Event::Traced(_) | Event::PassEnds { .. } => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        signals::came()
    }
}
