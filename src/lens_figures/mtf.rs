//! Modulation transfer of one field at one wavelength.

use glam::DVec2;
use photosite_lens::LensAt;
use photosite_lens::spots::geometric_mtf;

use super::figures::MtfFigures;

/// Frequencies, cycles per mm.
const FREQUENCIES_PER_MM: [f64; 11] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0];
/// Points along a side of the pupil where the wave front is nearly a sphere, and where it is less so.
const COARSE: usize = 64;
const FINE: usize = 128;
/// Up to so many waves the coarse grid follows the wave front: its steps stay far below half a wave.
const COARSE_WAVES: f64 = 0.5;
/// Beyond so many waves diffraction changes no MTF by 0.02, and rays tell it alone.
const MOST_WAVES: f64 = 2.0;
/// Rays along a side of the spot.
const RAYS: u32 = 60;

/// From the optical path differences where they are small; from rays where they are large. `None` where no light passes.
pub(super) fn mtf(at: &LensAt, field_rad: f64) -> Option<MtfFigures> {
    let coarse = at.wavefront(field_rad, COARSE)?;
    let rms_waves = coarse.rms_waves();
    let figures = |method, of: &dyn Fn(DVec2, f64) -> f64| MtfFigures {
        rms_waves,
        method,
        frequency_per_mm: FREQUENCIES_PER_MM.to_vec(),
        tangential: FREQUENCIES_PER_MM.iter().map(|&frequency| of(DVec2::Y, frequency)).collect(),
        sagittal: FREQUENCIES_PER_MM.iter().map(|&frequency| of(DVec2::X, frequency)).collect(),
    };
    if rms_waves <= MOST_WAVES {
        let wavefront = if rms_waves <= COARSE_WAVES { coarse } else { at.wavefront(field_rad, FINE)? };
        let spread = wavefront.point_spread();
        Some(figures("wave", &|axis, frequency| spread.mtf(axis, frequency)))
    } else {
        let points = at.spot_diagram(field_rad, RAYS);
        Some(figures("rays", &|axis, frequency| geometric_mtf(&points, axis, frequency)))
    }
}
