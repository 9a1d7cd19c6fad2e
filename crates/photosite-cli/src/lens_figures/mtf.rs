//! Modulation transfer of one field at one wavelength.

use glam::DVec2;
use photosite_lens::LensAt;
use photosite_lens::chief::ChiefRay;
use photosite_lens::spots::{ObjectPoint, geometric_mtf};

use super::figures::MtfFigures;

/// Frequencies, cycles per mm: all, and those in the text.
pub(super) const FREQUENCIES_PER_MM: [f64; 11] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0];
pub(super) const TOLD_PER_MM: [f64; 2] = [20.0, 40.0];
/// Optical path differences, in waves, beyond which diffraction changes no MTF by 0.02, so that rays alone suffice.
const MOST_WAVES: f64 = 2.0;
/// Number of directions of the rays of a spot, whose phases turn often at high frequencies.
const DIRECTIONS: usize = 180;

/// MTF of the object point on a chief ray at `distance_mm` from that ray's point on the first surface: from optical
/// path differences where these are small, from rays where they are large. `None` where no light of the point passes.
pub(super) fn mtf(at: &LensAt, chief: ChiefRay, distance_mm: f64, frequencies_per_mm: &[f64]) -> Option<MtfFigures> {
    let paths = at.path_differences(chief, distance_mm)?;
    let figures = |method, of: &dyn Fn(DVec2, f64) -> f64| MtfFigures {
        rms_waves: paths.rms_waves,
        lost: paths.lost,
        method,
        frequency_per_mm: frequencies_per_mm.to_vec(),
        tangential: frequencies_per_mm.iter().map(|&frequency| of(DVec2::Y, frequency)).collect(),
        sagittal: frequencies_per_mm.iter().map(|&frequency| of(DVec2::X, frequency)).collect(),
    };
    if paths.rms_waves <= MOST_WAVES {
        let spread = at.point_spread(chief, distance_mm)?;
        Some(figures("wave", &|axis, frequency| spread.mtf(axis, frequency)))
    } else {
        let points = at.spot(ObjectPoint::on(&chief, distance_mm), DIRECTIONS);
        Some(figures("rays", &|axis, frequency| geometric_mtf(&points, axis, frequency)))
    }
}
