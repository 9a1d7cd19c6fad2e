//! Exit statuses, for scripts and schedulers.

pub(super) const DONE: u8 = 0;
pub(super) const FAILED: u8 = 1;
pub(super) const WRONG_USAGE: u8 = 2;
/// Exit status of an error that may pass: EX_TEMPFAIL of sysexits.h.
pub(super) const ANOTHER_TRY: u8 = 75;
