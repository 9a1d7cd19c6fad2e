//! Exit statuses, which scripts and schedulers go by.

pub(super) const DONE: u8 = 0;
pub(super) const FAILED: u8 = 1;
pub(super) const WRONG_USAGE: u8 = 2;
/// EX_TEMPFAIL of sysexits.h.
pub(super) const ANOTHER_TRY: u8 = 75;
