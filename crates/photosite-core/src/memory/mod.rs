//! Limit of the program's memory, checked ahead: work that does not fit is refused before it allocates.
//!
//! Memory belongs to the process, as its heap does, so there is one limit for all of it: the one given to
//! [`set_limit`], or else the least of what the machine has left, what the control groups of the process allow and what
//! its resource limits (`ulimit -v`, `-d`) leave. Resource limits hold in any case. All figures are read anew for each
//! check, since other programs come and go. Linux reports them all; other systems have only the limit of [`set_limit`].
//!
//! Estimates are those of memory that is taken beyond what the process has at that time.

mod left;
mod system;

use std::sync::atomic::{AtomicU64, Ordering};

use crate::{Error, Invalid, Result, counted};
use left::GIB;

pub use left::Left;
pub use system::of_process;

/// Limit in bytes that was set; 0 for none.
static LIMIT: AtomicU64 = AtomicU64::new(0);

/// Lets the process take up to `gib` GiB, a number above 0, regardless of what the machine has.
///
/// # Errors
///
/// A number that is none.
pub fn set_limit(gib: f64) -> Result<()> {
    if !(gib.is_finite() && gib > 0.0) {
        let message =
            format!("{gib} GiB is not an amount of memory to work with; write a number above 0, for example 2.5");
        return Err(Error::Usage { message, help: None });
    }
    // The conversion saturates at the largest number.
    LIMIT.store(((gib * GIB) as u64).max(1), Ordering::Relaxed);
    Ok(())
}

/// Memory that the process can still take; `None` where no limit is known.
pub fn left() -> Option<Left> {
    system::System::read().left(LIMIT.load(Ordering::Relaxed))
}

/// Refuses work that needs more bytes than are left, see [`Left::check`].
///
/// # Errors
///
/// Errors of [`Left::check`].
pub fn check(bytes: u64, what: &str, instead: &str) -> Result<(), Invalid> {
    left().map_or(Ok(()), |left| left.check(bytes, what, instead))
}

/// Refuses threads whose stacks exceed the resource limits. Stacks are mapped whole and touched little, so that no
/// other limit counts.
///
/// # Errors
///
/// Errors of [`Left::check`].
pub fn check_threads(count: usize) -> Result<(), Invalid> {
    /// Bytes that the standard library maps for the stack of a thread.
    const STACK: u64 = 2 << 20;
    /// Bytes that the C library and this program map for the first threads. The C library ends the program without a
    /// message of ours where it lacks memory to start a thread.
    const BEGIN: u64 = 16 << 20;
    let what = format!("starting {}", counted(count, ["thread", "threads"]));
    let bytes = (count as u64).saturating_mul(STACK).saturating_add(BEGIN);
    let left = system::System::read().left_to_map();
    left.map_or(Ok(()), |left| left.check(bytes, &what, "lower --threads"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_numbers_above_0() {
        for gib in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(set_limit(gib).is_err(), "{gib}");
        }
    }
}
