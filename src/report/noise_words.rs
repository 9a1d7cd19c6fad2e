//! Monte Carlo noise beside the noise of the sensor, in words.

use crate::math::float::rounded;

/// The ratio at which rendering adds less than a hundredth to the noise of the sensor.
pub(crate) const UNSEEN: f64 = 0.14;

/// A ratio of standard deviations as a multiple: `0.5`, `2.4 times`.
pub(crate) fn times(ratio: f64) -> String {
    format!("{}{}", rounded(ratio, 2), if ratio < 1.0 { "" } else { " times" })
}

/// How far both together exceed the noise of the sensor.
pub(crate) fn together(ratio: f64) -> String {
    // Of independent errors, squares add.
    let both = ratio.hypot(1.0);
    if both < 2.0 {
        format!("both together are {} % more than the sensor's alone", rounded(100.0 * (both - 1.0), 2))
    } else {
        format!("both together are {} times the sensor's alone", rounded(both, 2))
    }
}
