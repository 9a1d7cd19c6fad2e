//! Memory that the process can still take, and the refusal of work that needs more.

use crate::Invalid;
use crate::help::{Help, Remedy};

/// Bytes in a GiB.
pub(super) const GIB: f64 = (1u64 << 30) as f64;

/// Sources of a limit on memory, in words: the limit of [`set_limit`](super::set_limit), and what the machine has.
pub(super) const TOLD: &str = "the limit that was set";
pub(super) const MACHINE: &str = "this machine";

/// Memory that the process can still take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Left {
    pub(super) bytes: u64,
    /// Bytes of the limit, including those already taken.
    pub(super) of: u64,
    pub(super) bound: &'static str,
}

impl Left {
    /// Remainder of a limit of `of` bytes, of which `taken` are in use.
    pub(super) fn of(of: u64, taken: u64, bound: &'static str) -> Self {
        Self { bytes: of.saturating_sub(taken), of, bound }
    }

    /// Bytes that the process can still take.
    pub fn bytes(self) -> u64 {
        self.bytes
    }

    /// Refuses work that needs more memory. `what` names the work; `instead` says how it takes less.
    ///
    /// # Errors
    ///
    /// Both figures, who says how much there is, and what to do.
    pub fn check(self, bytes: u64, what: &str, instead: &str) -> Result<(), Invalid> {
        if bytes <= self.bytes {
            return Ok(());
        }
        let Self { bytes: left, of, bound } = self;
        let taken = of.saturating_sub(left);
        let message = format!(
            "{what} takes {} of memory, and of the {} of {bound} {} are left",
            amount(bytes, f64::ceil),
            amount(of, f64::round),
            amount(left, f64::floor)
        );
        let more = match bound {
            TOLD => Remedy::Memory(gib(taken.saturating_add(bytes), f64::ceil)),
            MACHINE => "free some memory".into(),
            _ => Remedy::Say(format!("raise the limit to {} GiB", gib(taken.saturating_add(bytes), f64::ceil))),
        };
        let less = (!instead.is_empty()).then(|| instead.into());
        Err(Invalid::new("", message).help(Help::any(less.into_iter().chain([more]))))
    }
}

/// Amount in GiB, or in MiB below 128 MiB.
fn amount(bytes: u64, round: fn(f64) -> f64) -> String {
    if bytes >= 1 << 27 {
        return format!("{} GiB", gib(bytes, round));
    }
    format!("{} MiB", round(bytes as f64 / (1024.0 * 1024.0)))
}

/// Number of GiB with two decimals, rounded to the safe side.
fn gib(bytes: u64, round: fn(f64) -> f64) -> String {
    (round(bytes as f64 / GIB * 100.0) / 100.0).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_told_with_figures() {
        let left = |bound| Left { bytes: 1 << 29, of: 1 << 30, bound };
        assert_eq!(left(TOLD).check(1 << 29, "it", ""), Ok(()));
        let words = |bound| {
            let invalid = left(bound).check(3 << 30, "the image", "lower sensor.resolution_px").expect_err("too much");
            (invalid.message, invalid.help.expect("help").to_string())
        };
        let (message, help) = words(TOLD);
        assert_eq!(
            message,
            "the image takes 3 GiB of memory, and of the 1 GiB of the limit that was set 0.5 GiB are left"
        );
        assert_eq!(help, "lower sensor.resolution_px, or allow 3.5 GiB of memory");
        let small = Left { bytes: 3 << 19, of: 100 << 20, bound: TOLD }.check(5 << 19, "it", "").expect_err("too much");
        assert_eq!(
            small.message,
            "it takes 3 MiB of memory, and of the 100 MiB of the limit that was set 1 MiB are left"
        );
        let (message, help) = words("ulimit -v");
        assert!(message.contains("of the 1 GiB of ulimit -v 0.5 GiB"), "{message}");
        assert_eq!(help, "lower sensor.resolution_px, or raise the limit to 3.5 GiB");
    }
}
