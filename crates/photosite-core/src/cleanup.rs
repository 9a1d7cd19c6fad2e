//! Cleanup when the program ends early: temporary files, unfinished folders and locks are removed.
//!
//! A signal ends the program from another thread, where nothing is dropped. So each unfinished thing registers its
//! removal here, and whichever comes first runs it: its own drop, or the end of the program.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Removal of one unfinished thing. Errors are ignored, since nothing depends on the removal.
type Action = Box<dyn Fn() + Send>;

static OPEN: Mutex<Vec<(u64, Action)>> = Mutex::new(Vec::new());

fn open() -> MutexGuard<'static, Vec<(u64, Action)>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Guard of something unfinished, which is removed when the guard is dropped or the program ends.
#[derive(Debug)]
pub struct Cleanup {
    number: u64,
}

impl Cleanup {
    /// Registers a removal. The action must not create or drop another guard of this type.
    pub fn new(action: impl Fn() + Send + 'static) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        open().push((number, Box::new(action)));
        Self { number }
    }

    /// Keeps what was guarded: it is finished.
    pub fn disarm(self) {
        open().retain(|(number, _)| *number != self.number);
    }
}

impl Drop for Cleanup {
    fn drop(&mut self) {
        let mut open = open();
        if let Some(place) = open.iter().position(|(number, _)| *number == self.number) {
            // Under the lock, so that the program does not end halfway.
            let (_, action) = open.remove(place);
            action();
        }
    }
}

/// Proof that all cleanup has run. As long as it lives, no new guard can be registered.
pub struct AllClean {
    _open: MutexGuard<'static, Vec<(u64, Action)>>,
}

/// Runs all registered removals, the last registered first. The caller ends the program while it holds the returned
/// proof.
pub fn clean_up() -> AllClean {
    let mut open = open();
    while let Some((_, action)) = open.pop() {
        action();
    }
    AllClean { _open: open }
}
