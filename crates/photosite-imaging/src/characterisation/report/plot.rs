//! Plots with what is said about them.

use super::chart::Chart;

/// A plot with what is said about it.
pub struct Plot {
    /// What it shows.
    pub title: &'static str,
    /// What is said about it.
    pub caption: String,
    /// The plot.
    pub chart: Chart,
}

/// So many significant digits.
pub fn digits(x: f64, digits: i32) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let decimals = (digits - 1 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    format!("{x:.decimals$}")
}
