//! Numbers of a capture file that must lie in a range.

use std::time::Duration;

use photosite_core::Invalid;

/// A number above zero; `example` is one, for the message.
pub(crate) fn positive_number(key: &str, value: f64, example: &str) -> Result<f64, Invalid> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must be above 0, got {value}")).help(format!("for example {key} = {example}")))
}

/// A time above zero, s.
pub(crate) fn duration(key: &str, seconds: f64) -> Result<Duration, Invalid> {
    match Duration::try_from_secs_f64(seconds) {
        Ok(duration) if !duration.is_zero() => Ok(duration),
        Ok(_) | Err(_) => {
            Err(Invalid::new(key, format!("must be above 0, got {seconds}")).help(format!("for example {key} = 30")))
        }
    }
}
