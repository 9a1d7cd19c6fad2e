//! A mutex past its poison.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// What a mutex guards, though another thread may have panicked with it: its values are whole at all times.
pub(crate) fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}
