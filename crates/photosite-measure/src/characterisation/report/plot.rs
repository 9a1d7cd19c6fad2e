//! Plots with what is said about them.

use super::chart::Chart;

/// Plot with its title and caption.
pub struct Plot {
    /// Title of the plot.
    pub title: &'static str,
    /// Caption below the plot.
    pub caption: String,
    /// The plot.
    pub chart: Chart,
}

/// Writes a number with `digits` significant digits.
pub fn digits(x: f64, digits: i32) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let decimals = (digits - 1 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    format!("{x:.decimals$}")
}
