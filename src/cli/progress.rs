//! Progress on standard error: rate, time left, samples so far. Nothing where standard error is no terminal.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A progress bar over camera paths or images.
pub(super) struct Progress {
    bar: ProgressBar,
    start: Instant,
    /// What was done before it began.
    before: AtomicU64,
}

impl Progress {
    /// For a render of `paths` camera paths; silent on request or without a terminal.
    pub(super) fn new(paths: u64, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
        let bar = ProgressBar::with_draw_target(Some(paths), target);
        let template = "{elapsed_precise} [{bar:30}] {percent:>3} %  {msg}  {eta_precise} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, start: Instant::now(), before: AtomicU64::new(0) }
    }

    /// So many were done before.
    pub(super) fn start_at(&self, before: u64) {
        self.bar.set_position(before);
        self.before.store(before, Ordering::Relaxed);
    }

    /// For work on so many images.
    pub(super) fn over_images(images: u64, quiet: bool) -> Self {
        let progress = Self::new(images, quiet);
        progress.bar.set_message(format!("{images} images"));
        progress
    }

    /// Some more paths are traced, or images done.
    pub(super) fn advance(&self, paths: u64) {
        self.bar.inc(paths);
    }

    /// A pass is over, pixels have so many samples on average, and so many paths are expected in all.
    pub(super) fn pass(&self, samples: f64, expected_paths: u64) {
        self.bar.set_length(expected_paths);
        let seconds = self.start.elapsed().as_secs_f64().max(1e-9);
        let rate = self.bar.position().saturating_sub(self.before.load(Ordering::Relaxed)) as f64 / seconds / 1e6;
        self.bar.set_message(format!("{samples:.0} samples a pixel, {rate:.2} M paths/s"));
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
