//! Throttle of files that are written now and then beside a render: the time at which one is due again.

use std::time::{Duration, Instant};

/// Factor of the time that writing took last, after which the next is due: large images take a while.
const PATIENCE: u32 = 20;

/// Throttle with the next time, if there is one.
pub(crate) struct Throttle {
    interval: Option<Duration>,
    at: Option<Instant>,
}

impl Throttle {
    /// Throttle that is due for the first time once an interval has passed; never for `None`.
    pub(crate) fn every(interval: Option<Duration>) -> Self {
        Self { interval, at: interval.and_then(|interval| Instant::now().checked_add(interval)) }
    }

    pub(crate) fn is_never(&self) -> bool {
        self.interval.is_none()
    }

    pub(crate) fn is_now(&self) -> bool {
        self.at.is_some_and(|at| Instant::now() >= at)
    }

    /// Starts the next interval after work that took the time from `start` on.
    pub(crate) fn done_since(&mut self, start: Instant) {
        let now = Instant::now();
        let pause = self.interval.map(|interval| interval.max((now - start).saturating_mul(PATIENCE)));
        self.at = pause.and_then(|pause| now.checked_add(pause));
    }
}
