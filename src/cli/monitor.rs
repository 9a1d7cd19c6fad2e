//! What the user sees of work under way: warnings, and progress on standard error with rate and time left, where that is a
//! terminal.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use photosite::pipeline::{Event, Monitor};

use super::signals;

/// Tells the user, and stops on a signal.
pub(super) struct TerminalMonitor {
    /// Whether warnings are kept from the user.
    quiet: bool,
    /// Whether progress is.
    silent: bool,
    bar: Mutex<Option<ProgressBar>>,
    /// Whether the bar is over pictures of a data set, in which single pictures do not show.
    is_of_set: Mutex<bool>,
    start: Mutex<Instant>,
    /// Paths that were done before it began.
    before: AtomicU64,
}

impl TerminalMonitor {
    /// Where JSON is printed, there is no progress.
    pub(super) fn new(quiet: bool, json: bool) -> Self {
        Self {
            quiet,
            silent: quiet || json,
            bar: Mutex::new(None),
            is_of_set: Mutex::new(false),
            start: Mutex::new(Instant::now()),
            before: AtomicU64::new(0),
        }
    }

    fn begin(&self, length: u64) -> ProgressBar {
        let target = if self.silent { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
        let bar = ProgressBar::with_draw_target(Some(length), target);
        let template = "{elapsed_precise} [{bar:30}] {percent:>3} %  {msg}  {eta_precise} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        *locked(&self.start) = Instant::now();
        *locked(&self.bar) = Some(bar.clone());
        bar
    }

    fn end(&self) {
        if let Some(bar) = locked(&self.bar).take() {
            bar.finish_and_clear();
        }
    }

    fn advance(&self, by: u64) {
        if let Some(bar) = &*locked(&self.bar) {
            bar.inc(by);
        }
    }
}

fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Monitor for TerminalMonitor {
    fn report(&self, event: Event<'_>) {
        let is_of_set = *locked(&self.is_of_set);
        match event {
            Event::Warning(warning) if !self.quiet => eprintln!("warning: {warning}"),
            Event::TraceBegins { traced, expected, resumed, samples_per_pixel } => {
                signals::become_patient();
                if is_of_set {
                    return;
                }
                let bar = self.begin(expected);
                bar.set_position(traced);
                self.before.store(traced, Ordering::Relaxed);
                if let Some(checkpoint) = resumed.filter(|_| !self.silent) {
                    eprintln!("goes on from {} at {samples_per_pixel} samples a pixel", checkpoint.display());
                }
            }
            Event::Traced(paths) => self.advance(paths),
            Event::PassEnds { samples_per_pixel, expected } => {
                let Some(bar) = locked(&self.bar).clone() else { return };
                bar.set_length(expected);
                let seconds = locked(&self.start).elapsed().as_secs_f64().max(1e-9);
                let paths = bar.position().saturating_sub(self.before.load(Ordering::Relaxed));
                let rate = paths as f64 / seconds / 1e6;
                bar.set_message(format!("{samples_per_pixel:.0} samples a pixel, {rate:.2} M paths/s"));
            }
            Event::TraceEnds => {
                signals::become_impatient();
                if !is_of_set {
                    self.end();
                }
            }
            Event::SetBegins { pictures } => {
                *locked(&self.is_of_set) = true;
                self.begin(pictures).set_message(format!("{pictures} images"));
            }
            Event::PictureEnds => self.advance(1),
            Event::Waiting { pictures } if !self.quiet => {
                eprintln!("other processes are making {pictures} pictures, which are waited for");
            }
            Event::SetEnds => {
                *locked(&self.is_of_set) = false;
                self.end();
            }
            Event::Warning(_) | Event::Waiting { .. } => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        signals::came()
    }
}
