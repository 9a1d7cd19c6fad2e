//! Inverses of functions that rise.

/// The x in [0, end] at which a rising function takes a value, by Newton's method kept within a bracket that bisection
/// narrows where a step leaves it. `function` gives value and derivative; at 0 it is below the target, and where it
/// stays so up to `end` there is no such x. The search starts at `guess`.
#[inline]
pub(super) fn solve(function: impl Fn(f64) -> (f64, f64), target: f64, guess: f64, end: f64) -> Option<f64> {
    // The end itself counts, whatever roundings make of its value.
    let last = function(end).0;
    if target.is_nan() || target > last {
        return (target <= last * (1.0 + 4.0 * f64::EPSILON)).then_some(end);
    }
    let (mut low, mut high) = (0.0, end);
    let mut x = guess.clamp(low, high);
    // Newton's steps double the digits; bisection alone needs 64 to reach the last one of a large range.
    for _ in 0..128 {
        let (value, slope) = function(x);
        let error = value - target;
        if error > 0.0 {
            high = x
        } else {
            low = x
        }
        let newton = x - error / slope;
        let next = if (low..=high).contains(&newton) { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 2.0 * f64::EPSILON * x.abs() {
            return Some(next);
        }
        x = next;
    }
    Some(x)
}

/// First x in (0, end] at which a function that starts above 0 is no longer positive: found among `steps` even steps,
/// then halved down to the last digits. `None` where there is none.
pub(super) fn first_loss(positive: impl Fn(f64) -> bool, end: f64, steps: u32) -> Option<f64> {
    let at = |i: u32| end * f64::from(i) / f64::from(steps);
    let found = (1..=steps).find(|&i| !positive(at(i)))?;
    let (mut low, mut high) = (at(found - 1), at(found));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if positive(middle) { low = middle } else { high = middle }
    }
    Some(low)
}
