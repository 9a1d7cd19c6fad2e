//! When what is written now and then beside a render is due again.

use std::time::{Duration, Instant};

/// Next time comes after this many times as long as it took last: large pictures take a while.
const PATIENCE: u32 = 20;

/// The next time, if there is one.
pub(super) struct Throttle {
    interval: Option<Duration>,
    at: Option<Instant>,
}

impl Throttle {
    /// For the first time once an interval has passed; never for `None`.
    pub(super) fn every(interval: Option<Duration>) -> Self {
        Self { interval, at: interval.and_then(|interval| Instant::now().checked_add(interval)) }
    }

    pub(super) fn is_never(&self) -> bool {
        self.interval.is_none()
    }

    pub(super) fn is_now(&self) -> bool {
        self.at.is_some_and(|at| Instant::now() >= at)
    }

    /// Starts the next interval after work that took the time from `start` on.
    pub(super) fn done_since(&mut self, start: Instant) {
        let now = Instant::now();
        let pause = self.interval.map(|interval| interval.max((now - start).saturating_mul(PATIENCE)));
        self.at = pause.and_then(|pause| now.checked_add(pause));
    }
}
