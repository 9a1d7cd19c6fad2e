//! Airy's pattern of a round aperture: intensity (2J₁(x)/x)², x = πr/(λN), and the part of its light within x,
//! 1 − J₀²(x) − J₁²(x) ([Born99](photosite_core::references#born99) §8.5.2).

use std::sync::LazyLock;

/// Step of the table of enclosed light.
const STEP: f64 = 0.05;
/// End of the table, beyond which 1 % of the light lies.
const END: usize = 1280;

/// Enclosed light at multiples of the step.
static ENCLOSED: LazyLock<Vec<f64>> = LazyLock::new(|| (0..=END).map(|i| enclosed(i as f64 * STEP)).collect());

/// (2J₁(x)/x)², 1 in the middle.
#[inline]
pub(super) fn intensity(x: f64) -> f64 {
    if x < 1e-6 {
        return 1.0;
    }
    let amplitude = 2.0 * libm::j1(x) / x;
    amplitude * amplitude
}

/// The part of the light within x.
#[inline]
pub(super) fn enclosed(x: f64) -> f64 {
    let (j0, j1) = (libm::j0(x), libm::j1(x));
    1.0 - j0 * j0 - j1 * j1
}

/// The x within which the part `u` in [0, 1) of the light lies.
#[inline]
pub(super) fn radius(u: f64) -> f64 {
    let table = &*ENCLOSED;
    let after = table.partition_point(|&part| part <= u);
    // Outside, 1 − J₀² − J₁² ≥ 1 − 1/x, as J₀² + J₁² stays below 2/(πx)·(1 + 1/x).
    let (mut low, mut high) = match after {
        0 => return 0.0,
        within @ 1..=END => ((within - 1) as f64 * STEP, within as f64 * STEP),
        _ => (END as f64 * STEP, 1.0 / (1.0 - u)),
    };
    let mut x = 0.5 * (low + high);
    for _ in 0..60 {
        let error = enclosed(x) - u;
        if error > 0.0 {
            high = x
        } else {
            low = x
        }
        // Its derivative is 2J₁²/x = x·intensity/2, which vanishes on the dark rings.
        let newton = x - error / (0.5 * x * intensity(x));
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 1e-12 * x {
            return next;
        }
        x = next;
    }
    x
}
