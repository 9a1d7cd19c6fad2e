//! Containment of panics in third-party decoders.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Result of a decoder; `None` where it panics, and its state is discarded. No file is known that causes a panic:
/// damaged ones are refused by checks before, or by the decoder itself.
pub(super) fn contained<T>(decode: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(decode)).ok()
}
