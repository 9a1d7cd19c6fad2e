//! How much memory the program may take, and a look ahead: what does not fit is refused before it is asked for.
//!
//! Memory belongs to the process, as its heap does, so there is one limit for all of it: what [`set_limit`] was told, or
//! else the least of what the machine has left, what the control groups of the process allow and what its resource
//! limits (`ulimit -v`, `-d`) leave. Limits of resources cannot be passed and hold in any case. They are looked up at each
//! step, since other programs come and go. Linux tells all of this; on other systems only what was told is known.
//!
//! Estimates are those of memory that is taken beyond what the process has at that time.

mod left;
mod system;

use std::sync::atomic::{AtomicU64, Ordering};

use crate::{Error, Invalid, Result, counted};
use left::GIB;

pub use left::Left;

/// Bytes that the process may take; 0 where nobody said.
static LIMIT: AtomicU64 = AtomicU64::new(0);

/// Lets the process take so many GiB, a number above 0, whatever the machine has.
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

/// What there is for more; `None` where nobody says.
pub fn left() -> Option<Left> {
    system::System::read().left(LIMIT.load(Ordering::Relaxed))
}

/// Refuses what needs more bytes than there are, see [`Left::check`].
///
/// # Errors
///
/// As there.
pub fn check(bytes: u64, what: &str, instead: &str) -> Result<(), Invalid> {
    left().map_or(Ok(()), |left| left.check(bytes, what, instead))
}

/// Refuses threads whose stacks the resource limits do not leave room for. Stacks are mapped whole and touched little, so
/// that no other limit counts.
///
/// # Errors
///
/// Errors of [`Left::check`].
pub fn check_threads(count: usize) -> Result<(), Invalid> {
    /// Bytes that the standard library maps for each.
    const STACK: u64 = 2 << 20;
    /// What the C library and this program map for the first threads: the C library ends a program without a word of
    /// ours where it has no memory to begin a thread with.
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
