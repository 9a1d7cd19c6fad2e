//! Point spread functions: diffraction of the wave front of a point at the edge of the pupil.
//!
//! With the path differences W over the region S of direction cosines (p, q) at the sensor that pass every aperture,
//! the point spread function is |∬_S exp(2πi·(W(p, q) − p·x − q·y)/λ) dp dq|² at the place (x, y) relative to the chief
//! ray's landing point ([Born99](photosite_core::references#born99) §8.3 and §9.5; the coordinates are those of
//! [`illumination`](crate::illumination), so that they hold off the axis and at large apertures, too, but for the
//! polarisation of light).

use std::f64::consts::TAU;

use glam::DVec2;
use photosite_fft::{Complex32, Complex64, forward_f32};

use crate::chief::ChiefRay;
use crate::lens::Lens;
use crate::trace::{Apertures, LensAt};
use crate::wavefront::{Rays, Wavefront};

/// Factor of zero-padding of the pupil's grid, so that no frequency is folded onto another.
const PADDING: usize = 2;
/// Number of points along a side of the grid on which W is traced, before it is interpolated; margin of the grid beyond
/// the pupil, relative to its width; and numbers of directions in which the edge of the pupil is searched for, first
/// and then.
const TRACED: usize = 48;
const BEYOND: f64 = 0.05;
const FIRST_DIRECTIONS: usize = 32;
const DIRECTIONS: usize = 128;
/// Smallest and largest number of points along a side of the finer grid.
const FEWEST: usize = 128;
const MOST: usize = 1024;
/// Number of samples along a side of a point spread function: the usual and the largest.
const SIZE: usize = 512;
const LARGEST: usize = 1024;
/// Smallest half-width of a point spread function, relative to the farthest ray's distance from the middle.
const WIDER: f64 = 1.25;

/// The point spread function of an object point.
#[derive(Clone, Debug)]
pub struct PointSpread {
    /// Number of samples along a side.
    pub size: usize,
    /// Spacing of the samples on the sensor, mm.
    pub spacing_mm: f64,
    /// Energy in each sample; the sum is 1.
    pub energy: Vec<f32>,
    /// Position of the sample (size/2, size/2) relative to the chief ray's landing point, mm: the place to which the
    /// best-fit plane of W leads light.
    pub middle_mm: DVec2,
    /// Largest distance of landing rays from that place, mm.
    pub farthest_mm: f64,
}

impl Wavefront {
    /// Point spread function |FT of exp(2πi·W/λ)|², centred where the best-fit plane of W leads.
    pub fn point_spread(&self) -> PointSpread {
        let wavelength_mm = self.wavelength_nm * 1e-6;
        let of_path = |(path, covered): (Option<f64>, &f64)| {
            path.map_or(Complex32::default(), |path| phasor(*covered, path / wavelength_mm))
        };
        let field: Vec<Complex32> = self.levelled().into_iter().zip(&self.covered).map(of_path).collect();
        let middle_mm = self.plane(|number| self.covered[number]).map_or(DVec2::ZERO, |plane| plane.tilt_mm);
        let spread = PointSpread::of_field(&field, PADDING * self.size, wavelength_mm / self.spacing, false);
        PointSpread { middle_mm, farthest_mm: self.steepest_mm(|_| true, middle_mm), ..spread }
    }
}

impl LensAt<'_> {
    /// Point spread function of a point on a chief ray, at a distance from that ray's point on the first surface, mm:
    /// see [`wavefront_of`](Self::wavefront_of). `None` where no light of the point passes.
    ///
    /// W is traced on a grid of 48² points and interpolated by cubics on a grid that is fine enough for the farthest
    /// landing light, of 128² to 1024² points, which the edge of the pupil cuts in the middle of cells, too. Light that
    /// would land farther away than half the size of the grid is folded back into it: at a round pupil 2/(π²·n) of all
    /// light, with n the distance in units of λ·N, or 0.3 % on the smallest grid.
    pub fn point_spread(&self, chief: ChiefRay, distance_mm: f64) -> Option<PointSpread> {
        self.point_spreads(chief, distance_mm, std::slice::from_ref(self.lens)).pop()?
    }

    /// Point spread functions of a point on a chief ray through lenses that differ from this one only in the blades of
    /// their stops: W is traced once.
    pub(crate) fn point_spreads(&self, chief: ChiefRay, distance_mm: f64, lenses: &[Lens]) -> Vec<Option<PointSpread>> {
        let round = self.lens.with_round_stop();
        let at = LensAt { lens: &round, ..self.clone() };
        let rays = Rays::new(&at, chief, distance_mm);
        // About what passes to where the chief ray lands
        let traced = at.pupil_region(chief.image_height_mm, FIRST_DIRECTIONS).and_then(|passing| {
            let [low, high] = passing.bounds();
            let beyond = BEYOND * (high - low).max_element();
            // Not in the corners, where rays that no cell asks for are hardest to find.
            let counts = |point: DVec2| f64::from(passing.depth(point) > -2.0 * beyond);
            rays.wavefront([low - beyond, high + beyond], TRACED, |_| |point| (counts(point), point))
        });
        let of_lens = |lens: &Lens| {
            let at = LensAt { lens, ..self.clone() };
            Rays::new(&at, chief, distance_mm).point_spread(traced.as_ref()?)
        };
        lenses.iter().map(of_lens).collect()
    }
}

impl Rays<'_> {
    /// Point spread function of path differences that are traced on a coarse grid.
    fn point_spread(&self, traced: &Wavefront) -> Option<PointSpread> {
        // What passes of all that comes from the point
        let region = self.region(DIRECTIONS)?;
        let exact = self.landing_from_chief();
        let [low, high] = region.bounds();
        let width = (high - low).max_element();
        let cell = region.cells(traced.spacing);
        let plane = traced.plane(|number| cell(traced.cosines[number]).0)?;
        let wavelength_mm = traced.wavelength_nm * 1e-6;

        // As fine as half a wave from a point to the next at most
        let farthest_mm = traced.steepest_mm(|cosines| region.depth(cosines) >= 0.0, plane.tilt_mm);
        let needed = WIDER * 2.0 * width * farthest_mm / wavelength_mm;
        let fine = (needed as usize).next_power_of_two().clamp(FEWEST, MOST);
        let size = if fine <= SIZE / PADDING { SIZE } else { LARGEST };

        let spacing = width / fine as f64;
        let first = 0.5 * (low + high) - 0.5 * spacing * (fine as f64 - 1.0);
        let cell = region.cells(spacing);
        let mut field = Vec::with_capacity(fine * fine);
        for row in 0..fine {
            let y = first.y + spacing * row as f64;
            let along = traced.row(y);
            field.extend((0..fine).map(|column| {
                let (covered, cosines) = cell(DVec2::new(first.x + spacing * column as f64, y));
                if covered == 0.0 {
                    return Complex32::default();
                }
                // Cells that the edge cuts are asked in the middle of what is left of them.
                let known = if cosines.y == y {
                    along.as_ref().and_then(|along| along.at(cosines.x))
                } else {
                    traced.between(cosines)
                };
                let traced_here = || Some(self.path(exact(cosines)?, cosines, Apertures::Ignore)? - traced.zero_mm);
                let path = known.or_else(traced_here);
                path.map_or(Complex32::default(), |path| phasor(covered, (path - plane.at(cosines)) / wavelength_mm))
            }));
        }
        let spread = PointSpread::of_field(&field, size, wavelength_mm / spacing, is_mirrored(self.at.lens));
        Some(PointSpread { middle_mm: plane.tilt_mm, farthest_mm, ..spread })
    }
}

impl PointSpread {
    /// |FT|² of a field over a square of the pupil, zero-padded to `size`², which gives `width_mm` on the sensor. A
    /// field that is its own mirror image along each row has a result that is, too: half of it is computed.
    fn of_field(field: &[Complex32], size: usize, width_mm: f64, is_mirrored: bool) -> Self {
        let given = (field.len() as f64).sqrt() as usize;
        let fft = forward_f32(size);
        // Rows of nothing stay so.
        let mut rows = vec![Complex32::default(); given * size];
        for (row, of_row) in rows.chunks_mut(size).zip(field.chunks(given)) {
            row[..given].copy_from_slice(of_row);
        }
        fft.process(&mut rows);
        let known = if is_mirrored { size / 2 + 1 } else { size };
        let mut columns = vec![Complex32::default(); known * size];
        by_blocks(given, known, |row, column| columns[column * size + row] = rows[row * size + column]);
        fft.process(&mut columns);
        // Frequency 0 in the middle.
        let moved = |i: usize| (i + size / 2) % size;
        let mut energy = vec![0.0; size * size];
        by_blocks(size, size, |row, column| {
            let like = if column < known { column } else { size - column };
            energy[moved(row) * size + moved(column)] = columns[like * size + row].norm_sqr();
        });
        let total: f64 = energy.iter().copied().map(f64::from).sum();
        energy.iter_mut().for_each(|energy: &mut f32| *energy = (f64::from(*energy) / total) as f32);
        Self { size, spacing_mm: width_mm / size as f64, energy, middle_mm: DVec2::ZERO, farthest_mm: 0.0 }
    }

    /// Half-width of the point spread function from its middle, mm: light that would land farther away is folded back
    /// into it.
    pub fn reach_mm(&self) -> f64 {
        0.5 * self.size as f64 * self.spacing_mm
    }

    /// Modulation transfer function at a frequency ν in cycles per mm along `axis`, a unit vector: |Σ
    /// E·exp(−2πi·ν·x)|/Σ E, where single precision leaves Σ E a little beside 1.
    pub fn mtf(&self, axis: DVec2, frequency_per_mm: f64) -> f64 {
        // The phase is that of the column times that of the row.
        let phases = |along: f64| -> Vec<Complex64> {
            let step = -TAU * frequency_per_mm * self.spacing_mm * along;
            (0..self.size).map(|i| Complex64::cis(step * i as f64)).collect()
        };
        let (columns, rows) = (phases(axis.x), phases(axis.y));
        let row = |energy: &[f32]| -> Complex64 {
            energy.iter().zip(&columns).map(|(energy, phase)| phase * f64::from(*energy)).sum()
        };
        let sum: Complex64 = self.energy.chunks(self.size).zip(&rows).map(|(energy, phase)| row(energy) * phase).sum();
        let even = |energy: &[f32]| energy.iter().copied().map(f64::from).sum::<f64>();
        sum.norm() / self.energy.chunks(self.size).map(even).sum::<f64>()
    }
}

/// Whether a lens is its own mirror image across the plane of its field, including the blades of its stop.
fn is_mirrored(lens: &Lens) -> bool {
    /// Tolerance for rounding of the blades' normals, as they are turned.
    const ROUNDING: f64 = 1e-9;
    lens.stop_edges().is_none_or(|(normals, _)| {
        let has_mirrored =
            |normal: &DVec2| normals.iter().any(|n| n.distance(DVec2::new(-normal.x, normal.y)) < ROUNDING);
        normals.iter().all(has_mirrored)
    })
}

/// Field of a cell, from its covered fraction and its path in waves.
fn phasor(covered: f64, waves: f64) -> Complex32 {
    Complex32::from_polar(covered as f32, (TAU * (waves - waves.round())) as f32)
}

/// Visits rows and columns block by block, so that values read by rows and written by columns, or the other way, stay
/// in the cache.
fn by_blocks(rows: usize, columns: usize, mut visit: impl FnMut(usize, usize)) {
    /// Side of a block that fits into the fastest cache.
    const BLOCK: usize = 16;
    for block in (0..columns).step_by(BLOCK) {
        for row in 0..rows {
            (block..columns.min(block + BLOCK)).for_each(|column| visit(row, column));
        }
    }
}
