//! What there is for more, and the refusal of what does not fit.

use std::fmt;

use crate::Invalid;
use crate::help::{Help, Remedy};

/// Bytes.
pub(super) const GIB: f64 = (1u64 << 30) as f64;

/// Who says how much there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bound {
    /// [`set_limit`].
    Told,
    Machine,
    ControlGroup,
    /// Of address space and of data.
    AddressSpace,
    Data,
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Told => "the limit that was set",
            Self::Machine => "this machine",
            Self::ControlGroup => "the control group of the process",
            Self::AddressSpace => "ulimit -v",
            Self::Data => "ulimit -d",
        })
    }
}

/// What there is for more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Left {
    pub(super) bytes: u64,
    /// All that there is, what is taken already included.
    pub(super) of: u64,
    pub(super) bound: Bound,
}

impl Left {
    /// What is left of all that there is.
    pub(super) fn of(of: u64, taken: u64, bound: Bound) -> Self {
        Self { bytes: of.saturating_sub(taken), of, bound }
    }

    /// Bytes.
    pub fn bytes(self) -> u64 {
        self.bytes
    }

    /// Refuses what needs more. `what` takes the memory; `instead` says how it takes less.
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
            Bound::Told => Remedy::Memory(gib(taken.saturating_add(bytes), f64::ceil)),
            Bound::Machine => "free some memory".into(),
            Bound::ControlGroup | Bound::AddressSpace | Bound::Data => {
                Remedy::Say(format!("raise the limit to {} GiB", gib(taken.saturating_add(bytes), f64::ceil)))
            }
        };
        let less = (!instead.is_empty()).then(|| instead.into());
        Err(Invalid::new("", message).help(Help::any(less.into_iter().chain([more]))))
    }
}

/// In GiB, or in MiB where GiB would need more digits.
fn amount(bytes: u64, round: fn(f64) -> f64) -> String {
    if bytes >= 1 << 27 {
        return format!("{} GiB", gib(bytes, round));
    }
    format!("{} MiB", round(bytes as f64 / (1024.0 * 1024.0)))
}

/// GiB in two digits after the point, rounded to the side that is safe.
fn gib(bytes: u64, round: fn(f64) -> f64) -> String {
    (round(bytes as f64 / GIB * 100.0) / 100.0).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_told_with_figures() {
        let left = |bound| Left { bytes: 1 << 29, of: 1 << 30, bound };
        assert_eq!(left(Bound::Told).check(1 << 29, "it", ""), Ok(()));
        let words = |bound| {
            let invalid =
                left(bound).check(3 << 30, "the picture", "lower sensor.resolution_px").expect_err("too much");
            (invalid.message, invalid.help.expect("help").to_string())
        };
        let (message, help) = words(Bound::Told);
        assert_eq!(
            message,
            "the picture takes 3 GiB of memory, and of the 1 GiB of the limit that was set 0.5 GiB are left"
        );
        assert_eq!(help, "lower sensor.resolution_px, or allow 3.5 GiB of memory");
        let small =
            Left { bytes: 3 << 19, of: 100 << 20, bound: Bound::Told }.check(5 << 19, "it", "").expect_err("too much");
        assert_eq!(
            small.message,
            "it takes 3 MiB of memory, and of the 100 MiB of the limit that was set 1 MiB are left"
        );
        let (message, help) = words(Bound::AddressSpace);
        assert!(message.contains("of the 1 GiB of ulimit -v 0.5 GiB"), "{message}");
        assert_eq!(help, "lower sensor.resolution_px, or raise the limit to 3.5 GiB");
    }
}
