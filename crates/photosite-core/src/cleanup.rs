//! What has to be put away when the program ends early: temporary files, unfinished folders, locks.
//!
//! A signal ends the program from another thread, where nothing is dropped. So what is unfinished says here how to be
//! put away, and is put away by whichever comes first: its own drop, or the end of the program.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Puts something away, and lets pass what cannot be: nothing depends on it.
type Action = Box<dyn Fn() + Send>;

static OPEN: Mutex<Vec<(u64, Action)>> = Mutex::new(Vec::new());

fn open() -> MutexGuard<'static, Vec<(u64, Action)>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Something unfinished, put away when this is dropped or when the program ends.
#[derive(Debug)]
pub struct Cleanup {
    number: u64,
}

impl Cleanup {
    /// Registers how something is put away. The action must not create or drop another of these.
    pub fn new(action: impl Fn() + Send + 'static) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        open().push((number, Box::new(action)));
        Self { number }
    }

    /// It is finished, and stays.
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

/// Everything is put away, and as long as this lives, nothing new can be begun.
pub struct AllClean {
    _open: MutexGuard<'static, Vec<(u64, Action)>>,
}

/// Puts everything away, what came last first. The caller ends the program while it holds what this returns.
pub fn clean_up() -> AllClean {
    let mut open = open();
    while let Some((_, action)) = open.pop() {
        action();
    }
    AllClean { _open: open }
}
