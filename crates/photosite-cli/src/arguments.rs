//! Values of arguments that several commands share.

use std::ops::Range;

use photosite_core::{Invalid, counted, memory};

use photosite_core::Error;

/// Starts the requested number of threads, where their stacks fit.
pub(super) fn start_threads(threads: Option<u16>) -> photosite_core::Result<()> {
    /// Number of threads that slow down a small machine only a little while they wait for each other.
    const FEW: usize = 256;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let most = FEW.max(4 * cores);
    // Of none rayon makes as many as there are cores, or as RAYON_NUM_THREADS says.
    let threads = threads.map_or(0, usize::from);
    if threads > most {
        let message = format!("--threads {threads}: at most {most} can be used");
        let help = format!("this machine runs {cores} at once; more would not be faster");
        return Err(Error::Usage { message, help: Some(help.into()) });
    }
    let count = if threads == 0 { cores } else { threads };
    let checked = memory::check_threads(count);
    checked.map_err(|Invalid { message, help, .. }| Error::Resources { message, help })?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    pool.map_err(|reason| no_threads(count, &reason))
}

/// Error of threads that the system does not start.
pub(super) fn no_threads(count: usize, reason: &dyn std::fmt::Display) -> Error {
    let message = format!("cannot start {}: {reason}", counted(count, ["thread", "threads"]));
    let help = "lower --threads, or raise the limits of memory (ulimit -v) and of processes (ulimit -u)";
    Error::Resources { message, help: Some(help.into()) }
}

/// Parses a range of integers, `A..B`: from A up to, but not including, B.
pub(super) fn parse_range(text: &str) -> Result<Range<u32>, String> {
    let number = |part: &str| part.trim().parse::<u32>().ok();
    let ends = text.split_once("..").and_then(|(a, b)| Some((number(a)?, number(b)?)));
    match ends {
        Some((a, b)) if a < b => Ok(a..b),
        Some(_) => Err("the first number must be below the second".to_owned()),
        None => Err("write two whole numbers, for example 0..10".to_owned()),
    }
}

/// Parses a finite number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or_else(|| "write a number above 0".to_owned())
}

/// Two numbers above 0, `800x600`.
pub(super) fn sides(text: &str) -> Option<[u32; 2]> {
    let number = |part: &str| part.trim().parse::<u32>().ok().filter(|side| *side > 0);
    text.split_once(['x', 'X', '×']).and_then(|(width, height)| Some([number(width)?, number(height)?]))
}

/// Evenly spaced values: first, last and step, `380..1000:10`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Steps([f64; 3]);

impl Steps {
    /// First, last, and what lies between them.
    pub(super) fn values(self) -> Vec<f64> {
        let [first, last, step] = self.0;
        // The last value belongs to it, whatever rounding makes of the division.
        let count = ((last - first) / step * (1.0 + 1e-12)).floor() as u32;
        (0..=count).map(|i| first + f64::from(i) * step).collect()
    }
}

/// Largest number of evenly spaced values.
const MOST_VALUES: f64 = 10_000.0;

/// Parses evenly spaced values, `first..last:step`.
pub(super) fn parse_steps(text: &str) -> Result<Steps, String> {
    let wrong = || "write first, last and step, for example 380..1000:10".to_owned();
    let (ends, step) = text.split_once(':').ok_or_else(wrong)?;
    let (first, last) = ends.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str| text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(wrong);
    let steps = [number(first)?, number(last)?, number(step)?];
    let [first, last, step] = steps;
    if step > 0.0 && last >= first && (last - first) / step < MOST_VALUES { Ok(Steps(steps)) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evenly_spaced_values_hold_both_ends() {
        let sweep = parse_steps("380..1000:10").expect("steps").values();
        assert_eq!((sweep.len(), sweep[0], sweep[62]), (63, 380.0, 1000.0));
        assert_eq!(parse_steps("-0.3..0.3:0.1").expect("steps").values().len(), 7);
        assert_eq!(parse_steps("25..25:5").expect("steps").values(), [25.0]);
        for wrong in ["380..1000", "380-1000:10", "1000..380:10", "0..1:0", "0..inf:1", "0..1e9:1e-3"] {
            assert!(parse_steps(wrong).is_err(), "{wrong}");
        }
    }
}
