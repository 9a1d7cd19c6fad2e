//! Lenses that ship with photosite, with the figures by which one is chosen.

use photosite_lens::files;

use super::compute::{Options, lenses};
use photosite_core::Result;
use photosite_core::spectrum::dispersion::lines;

/// Lens that ships with photosite.
pub(crate) struct ShippedLens {
    /// Name of the lens on the command line and in captures.
    pub name: &'static str,
    /// Shortest and longest focal length at d, mm; equal unless it is a zoom.
    pub focal_length_mm: [f64; 2],
    /// Smallest and largest f-number of the open lens.
    pub f_number: [f64; 2],
    /// Description of the lens.
    pub description: String,
}

/// All lenses that ship, sorted by name.
///
/// # Errors
///
/// Errors of [`LensFigures`](super::LensFigures), of which a lens that ships has none.
pub(crate) fn shipped_lenses() -> Result<Vec<ShippedLens>> {
    let row = |name| {
        let reading = files::shipped(name)?;
        let first_orders = lenses(&reading, &Options::default()).map(|lenses| {
            let of = lenses.iter().map(|(_, lens)| lens.at(lines::D).first_order());
            let range = |values: Vec<f64>| {
                [values.iter().copied().fold(f64::INFINITY, f64::min), values.iter().copied().fold(0.0, f64::max)]
            };
            let (lengths, numbers) = of.map(|first| (first.efl_mm, first.f_number)).unzip();
            let description = reading.prescription.name.clone();
            ShippedLens { name, focal_length_mm: range(lengths), f_number: range(numbers), description }
        });
        Some(first_orders)
    };
    files::names().filter_map(row).collect()
}
