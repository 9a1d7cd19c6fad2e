//! Decoders of other hands, whose mistakes stay with the file that shows them.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a decoder gives; `None` where it gives up on its own state, which is thrown away. No file is known that makes
/// one do so: damaged ones are refused by checks before, or by the decoder itself.
pub(super) fn contained<T>(decode: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(decode)).ok()
}
