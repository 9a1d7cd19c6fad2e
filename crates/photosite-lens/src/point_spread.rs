//! The picture of a point: diffraction of its wave front at the edge of the pupil.
//!
//! With the path differences W over the direction cosines (p, q) at the sensor that pass every aperture, the region S, it is
//! |∬_S exp(2πi·(W(p, q) − p·x − q·y)/λ) dp dq|² at the place (x, y) from where the chief ray lands
//! ([Born99](photosite_core::references#born99) §8.3 and §9.5; the coordinates are those of
//! [`illumination`](crate::illumination), so that they hold off the axis and at large apertures, too, but for the
//! polarisation of light).

use std::f64::consts::TAU;

use glam::DVec2;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

use crate::chief::ChiefRay;
use crate::trace::{Apertures, LensAt};
use crate::wavefront::{Rays, Wavefront};

/// The grid of the pupil is zero-padded to this many times its size, so that no frequency is folded onto another.
const PADDING: usize = 2;
/// Points along a side of the grid on which W is traced, before it is interpolated; how far beyond the pupil the grid
/// reaches, as a part of its width; and directions in which the edge of the pupil
/// is looked for, at first and then.
const TRACED: usize = 48;
const BEYOND: f64 = 0.05;
const FIRST_DIRECTIONS: usize = 32;
const DIRECTIONS: usize = 128;
/// Points along a side of the finer grid: at least, and at most.
const FEWEST: usize = 128;
const MOST: usize = 1024;
/// Samples along a side of a picture: of the usual one, and of the largest.
const SIZE: usize = 512;
const LARGEST: usize = 1024;
/// How much farther from the middle than rays land the picture reaches at least.
const WIDER: f64 = 1.25;

/// The picture of a point.
#[derive(Clone, Debug)]
pub struct PointSpread {
    /// Samples along a side.
    pub size: usize,
    /// Distance of the samples on the sensor, mm.
    pub spacing_mm: f64,
    /// Energy in each sample, of 1 in all.
    pub energy: Vec<f64>,
    /// Where sample (size/2, size/2) lies, from where the chief ray lands, mm: where the plane that fits W best leads light.
    pub middle_mm: DVec2,
    /// How far from there rays land at most, mm.
    pub farthest_mm: f64,
}

impl Wavefront {
    /// The picture of the point, |FT of exp(2πi·W/λ)|², about where the best plane of W leads.
    pub fn point_spread(&self) -> PointSpread {
        let wavelength_mm = self.wavelength_nm * 1e-6;
        let of_path = |(path, covered): (Option<f64>, &f64)| {
            path.map_or(Complex64::default(), |path| Complex64::from_polar(*covered, TAU * path / wavelength_mm))
        };
        let field: Vec<Complex64> = self.levelled().into_iter().zip(&self.covered).map(of_path).collect();
        let middle_mm = self.plane(|number| self.covered[number]).map_or(DVec2::ZERO, |plane| plane.tilt_mm);
        let spread = PointSpread::of_field(&field, PADDING * self.size, wavelength_mm / self.spacing);
        PointSpread { middle_mm, farthest_mm: self.steepest_mm(|_| true, middle_mm), ..spread }
    }
}

impl LensAt<'_> {
    /// The picture of a point that lies on a chief ray, as far from that ray's point on the first surface, mm: see
    /// [`wavefront_of`](Self::wavefront_of). `None` where no light of it passes.
    ///
    /// W is traced on a grid of 48² points and interpolated by cubics on a grid that is fine enough for how far light lands
    /// from the middle, of 128² to 1024² points, which the edge of the pupil cuts in the middle of cells, too. Light that
    /// would land farther away than half the size of the picture is folded back into it: at a round pupil
    /// 2/(π²·n) of all, with n the distance in units of λ·N, 0.3 % of the smallest.
    pub fn point_spread(&self, chief: ChiefRay, distance_mm: f64) -> Option<PointSpread> {
        let rays = Rays::new(self, chief, distance_mm);
        // About what passes to where the chief ray lands
        let passing = self.pupil_region(chief.image_height_mm, FIRST_DIRECTIONS)?;
        let [low, high] = passing.bounds();
        let beyond = BEYOND * (high - low).max_element();
        let traced = rays.wavefront([low - beyond, high + beyond], TRACED, |point, _| (1.0, point))?;

        // What passes of all that comes from the point
        let exact = rays.landing_from_chief();
        let landing = |cosines: DVec2| traced.between(cosines).map(|(_, point)| point).or_else(|| exact(cosines));
        let region = rays.region(landing, DIRECTIONS)?;
        let [low, high] = region.bounds();
        let width = (high - low).max_element();
        let plane = traced.plane(|number| region.cell(traced.cosines[number], traced.spacing).0)?;
        let wavelength_mm = self.wavelength_nm * 1e-6;

        // As fine as half a wave from a point to the next at most
        let farthest_mm = traced.steepest_mm(|cosines| region.depth(cosines) >= 0.0, plane.tilt_mm);
        let needed = WIDER * 2.0 * width * farthest_mm / wavelength_mm;
        let fine = (needed as usize).next_power_of_two().clamp(FEWEST, MOST);
        let size = if fine <= SIZE / PADDING { SIZE } else { LARGEST };

        let spacing = width / fine as f64;
        let first = 0.5 * (low + high) - 0.5 * spacing * (fine as f64 - 1.0);
        let at = |i: usize| {
            let point = first + spacing * DVec2::new((i % fine) as f64, (i / fine) as f64);
            let (covered, cosines) = region.cell(point, spacing);
            let traced_here = || Some(rays.path(exact(cosines)?, cosines, Apertures::Ignore)? - traced.zero_mm);
            let path = || traced.between(cosines).map(|(path, _)| path).or_else(traced_here);
            match if covered > 0.0 { path() } else { None } {
                Some(path) => Complex64::from_polar(covered, TAU * (path - plane.at(cosines)) / wavelength_mm),
                None => Complex64::default(),
            }
        };
        let field: Vec<Complex64> = (0..fine * fine).map(at).collect();
        let spread = PointSpread::of_field(&field, size, wavelength_mm / spacing);
        Some(PointSpread { middle_mm: plane.tilt_mm, farthest_mm, ..spread })
    }
}

impl PointSpread {
    /// |FT|² of a field over a square of the pupil, zero-padded to `size`², whose picture is `width_mm` wide.
    fn of_field(field: &[Complex64], size: usize, width_mm: f64) -> Self {
        let given = (field.len() as f64).sqrt() as usize;
        let fft = FftPlanner::new().plan_fft_forward(size);
        let mut padded = vec![Complex64::default(); size * size];
        for (row, of_row) in field.chunks(given).enumerate() {
            padded[row * size..][..given].copy_from_slice(of_row);
        }
        // Rows, then columns: a transposition, twice over, leaves the order as it was. Rows of nothing stay so.
        fft.process(&mut padded[..given * size]);
        padded = transposed(&padded, size);
        fft.process(&mut padded);
        padded = transposed(&padded, size);
        let total: f64 = padded.iter().map(Complex64::norm_sqr).sum();
        // Frequency 0 in the middle.
        let moved = |i: usize| (i + size - size / 2) % size;
        let energy = (0..size * size).map(|i| padded[moved(i / size) * size + moved(i % size)].norm_sqr() / total);
        let (spacing_mm, energy) = (width_mm / size as f64, energy.collect());
        Self { size, spacing_mm, energy, middle_mm: DVec2::ZERO, farthest_mm: 0.0 }
    }

    /// How far from the middle it reaches, mm: light that would land farther away is folded back into it.
    pub fn reach_mm(&self) -> f64 {
        0.5 * self.size as f64 * self.spacing_mm
    }

    /// The modulation transfer at a frequency ν in cycles per mm along `axis`, a unit vector: |Σ E·exp(−2πi·ν·x)|.
    pub fn mtf(&self, axis: DVec2, frequency_per_mm: f64) -> f64 {
        let middle = (self.size / 2) as f64;
        let at = |i: usize| DVec2::new((i % self.size) as f64 - middle, (i / self.size) as f64 - middle);
        let phase = |i: usize| -TAU * frequency_per_mm * self.spacing_mm * at(i).dot(axis);
        let all = self.energy.iter().enumerate().map(|(i, energy)| DVec2::from_angle(phase(i)) * *energy);
        all.sum::<DVec2>().length()
    }
}

/// Rows of a square as columns.
fn transposed(square: &[Complex64], size: usize) -> Vec<Complex64> {
    /// So many of each fit into the fastest memory.
    const BLOCK: usize = 16;
    let mut turned = vec![Complex64::default(); size * size];
    for block in (0..size).step_by(BLOCK) {
        for row in 0..size {
            for column in block..size.min(block + BLOCK) {
                turned[column * size + row] = square[row * size + column];
            }
        }
    }
    turned
}
