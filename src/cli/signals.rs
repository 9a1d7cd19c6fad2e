//! Signals that ask the program to end: SIGINT (130), SIGTERM (143), and SIGHUP (129) unless it is ignored, as under `nohup`.
//!
//! Work that can be kept is left to stop by itself ([`Patience`]): it looks at [`stop`] some times a second, keeps what is done
//! in a checkpoint, and fails with [`stopped`]. All other work ends at once, without its temporary files. A second signal ends
//! everything at once.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use photosite::Error;

/// Added to a signal's number, this is the exit status that shells give it.
const BASE: i32 = 128;

/// The number of the signal that came; 0 while there was none.
static CAME: AtomicI32 = AtomicI32::new(0);
/// Whether the work under way stops by itself.
static PATIENT: Mutex<bool> = Mutex::new(false);

fn patient() -> MutexGuard<'static, bool> {
    PATIENT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// While it lives, a first signal does not end the program: the work stops by itself.
pub(super) struct Patience(());

impl Patience {
    pub(super) fn begin() -> Self {
        *patient() = true;
        Self(())
    }

    /// Whether no signal has come. From now on it ends the program at once again.
    pub(super) fn end(self) -> ControlFlow<()> {
        *patient() = false;
        stop()
    }
}

impl Drop for Patience {
    fn drop(&mut self) {
        *patient() = false;
    }
}

/// Whether work shall stop.
pub(super) fn stop() -> ControlFlow<()> {
    if CAME.load(Ordering::Relaxed) == 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}

/// What work that was stopped fails with; `help` says how it goes on.
pub(super) fn stopped(help: String) -> Error {
    let number = CAME.load(Ordering::Relaxed);
    let name = match number {
        1 => "SIGHUP",
        2 => "SIGINT",
        _ => "SIGTERM",
    };
    Error::Cancelled { message: format!("stopped by {name}"), help: Some(help) }
}

/// The exit status of a program that was stopped.
pub(super) fn status() -> u8 {
    u8::try_from(BASE + CAME.load(Ordering::Relaxed)).unwrap_or(u8::MAX)
}

/// Listens from now on.
#[cfg(unix)]
pub(super) fn listen() {
    use photosite::io::cleanup::clean_up;
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    // Shells let commands in the background ignore SIGINT, and nohup lets them ignore SIGHUP: so it stays.
    let wanted = [SIGTERM, SIGINT, SIGHUP].into_iter().filter(|&signal| !is_ignored(signal));
    // Where there is no listening, signals end the program as they end any.
    let Ok(mut signals) = Signals::new(wanted) else { return };
    std::thread::spawn(move || {
        for signal in signals.forever() {
            // Held on to in the end: nobody becomes patient then.
            let patient = patient();
            let is_first = CAME.swap(signal, Ordering::Relaxed) == 0;
            if !(is_first && *patient) {
                let _clean = clean_up();
                std::process::exit(BASE + signal);
            }
        }
    });
}

#[cfg(not(unix))]
pub(super) fn listen() {}

/// Whether a signal was ignored when the program began, as far as the system tells.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}
