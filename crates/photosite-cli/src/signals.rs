//! Signals that ask the program to end: SIGINT (130), SIGTERM (143), and SIGHUP (129) unless it is ignored, as under
//! `nohup`.
//!
//! Work that can be kept is left to stop by itself ([`become_patient`]): it looks at [`came`] some times a second, and
//! keeps what is done in a checkpoint. All other work ends at once, without its temporary files. A second signal ends
//! everything at once, except the same signal within a second: a scheduler signals all processes of a job, and its
//! script passes the signal on.

use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Time within which a repeated signal counts as the same one.
#[cfg(unix)]
const ONE_SIGNAL: std::time::Duration = std::time::Duration::from_secs(1);
/// Offset of exit statuses: added to a signal's number, it is the status that shells report for it.
const BASE: i32 = 128;

/// Number of the signal that came; 0 while there was none.
static CAME: AtomicI32 = AtomicI32::new(0);
/// Number of pieces of work under way that stop by themselves.
static PATIENT: Mutex<u32> = Mutex::new(0);

fn patient() -> MutexGuard<'static, u32> {
    PATIENT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Announces work that stops by itself, so that a first signal does not end the program.
pub(super) fn become_patient() {
    *patient() += 1;
}

/// Ends the announcement: when no work is left that stops by itself, a signal ends the program at once again. After the
/// return, it is known whether a signal has come since [`become_patient`].
pub(super) fn become_impatient() {
    let mut patient = patient();
    *patient = patient.saturating_sub(1);
}

/// Whether a signal has come.
pub(super) fn came() -> bool {
    CAME.load(Ordering::Relaxed) != 0
}

/// Name of the signal that came, in words.
pub(super) fn stopped_by() -> &'static str {
    match CAME.load(Ordering::Relaxed) {
        1 => "stopped by SIGHUP",
        2 => "stopped by SIGINT",
        _ => "stopped by SIGTERM",
    }
}

/// Exit status of a program that was stopped by a signal.
pub(super) fn status() -> u8 {
    u8::try_from(BASE + CAME.load(Ordering::Relaxed)).unwrap_or(u8::MAX)
}

/// Starts to listen to signals.
#[cfg(unix)]
pub(super) fn listen() -> photosite_core::Result<()> {
    use photosite_core::cleanup::clean_up;
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use std::time::Instant;

    // Shells let commands in the background ignore SIGINT, and nohup lets them ignore SIGHUP: so it stays.
    let wanted = [SIGTERM, SIGINT, SIGHUP].into_iter().filter(|&signal| !is_ignored(signal));
    // Where there is no listening, signals end the program as they end any.
    let Ok(mut signals) = Signals::new(wanted) else { return Ok(()) };
    let listening = std::thread::Builder::new().spawn(move || {
        let mut first: Option<(i32, Instant)> = None;
        for signal in signals.forever() {
            // Held on to in the end: nobody becomes patient then.
            let patient = patient();
            CAME.store(signal, Ordering::Relaxed);
            let (known, since) = *first.get_or_insert_with(|| (signal, Instant::now()));
            if !(known == signal && since.elapsed() < ONE_SIGNAL && *patient > 0) {
                let _clean = clean_up();
                std::process::exit(BASE + signal);
            }
        }
    });
    listening.map(|_| ()).map_err(|reason| super::arguments::no_threads(1, &reason))
}

#[cfg(not(unix))]
pub(super) fn listen() -> photosite_core::Result<()> {
    Ok(())
}

/// Whether a signal was ignored when the program began, as far as the system tells.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}
