//! Optical path differences, and the point spread and modulation that they make by diffraction.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2, DVec3};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

use crate::chief::ChiefRay;
use crate::profile::Travel;
use crate::region::Region;
use crate::trace::{Apertures, LensAt, Step};

/// Directions in which the edge of the pupil is looked for.
const DIRECTIONS: usize = 64;
/// Newton's method for the sensor point has come to the object's direction where it is this near, rad.
const TOLERANCE: f64 = 1e-11;
/// Most steps of it.
const MOST_STEPS: usize = 20;
/// The step of its derivatives, mm.
const STEP_MM: f64 = 1e-4;
/// The grid of the pupil is zero-padded to this many times its size, so that no frequency is folded onto another.
const PADDING: usize = 2;

/// The optical path differences of the light of one object point over the pupil, in image-side direction cosines.
#[derive(Clone, Debug)]
pub struct Wavefront {
    /// The wavelength, nm.
    pub wavelength_nm: f64,
    /// Points along a side of the grid.
    pub size: usize,
    /// Distance of the points of the grid in direction cosines.
    pub spacing: f64,
    /// W at the points of the grid, mm, row by row (p fastest, q up); `None` where an aperture cuts the ray off.
    pub path_mm: Vec<Option<f64>>,
}

/// The picture of a point.
#[derive(Clone, Debug)]
pub struct PointSpread {
    /// Samples along a side.
    pub size: usize,
    /// Distance of the samples on the sensor, mm.
    pub spacing_mm: f64,
    /// Energy in each sample, of 1 in all; the chief ray lands on sample (size/2, size/2).
    pub energy: Vec<f64>,
}

/// Finds the rays of one object point by their direction at the sensor.
struct Rays<'a> {
    at: &'a LensAt<'a>,
    chief: ChiefRay,
    /// Unit vectors across the object's direction.
    across: [DVec3; 2],
}

impl Rays<'_> {
    /// How far the ray from a sensor point with some direction cosines is from the object's direction in the scene, rad.
    fn miss(&self, point: DVec2, cosines: DVec2) -> Option<DVec2> {
        let out = self.at.trace_out(self.at.ray_from_sensor(point, cosines), Apertures::Ignore).ok()?;
        Some(DVec2::new(out.direction.dot(self.across[0]), out.direction.dot(self.across[1])))
    }

    /// The sensor point at which the object's light arrives with these direction cosines, by Newton's method.
    fn landing(&self, start: DVec2, cosines: DVec2) -> Option<DVec2> {
        let mut point = start;
        for _ in 0..MOST_STEPS {
            let miss = self.miss(point, cosines)?;
            if miss.length() < TOLERANCE {
                return Some(point);
            }
            let derivative = |step: DVec2| Some((self.miss(point + step, cosines)? - miss) / STEP_MM);
            let jacobian = DMat2::from_cols(derivative(DVec2::X * STEP_MM)?, derivative(DVec2::Y * STEP_MM)?);
            point -= jacobian.inverse() * miss;
            if !point.is_finite() {
                return None;
            }
        }
        None
    }

    /// W = the optical path from a wave front of the object to the sensor less D·(landing − chief landing), D the
    /// direction there, mm.
    fn path(&self, point: DVec2, cosines: DVec2, apertures: Apertures) -> Option<f64> {
        let ray = self.at.ray_from_sensor(point, cosines);
        let steps = (0..self.at.lens.surfaces().len()).rev().map(Step::refract);
        let mut length = 0.0;
        let out =
            self.at.trace(ray, Travel::ToScene, steps, apertures, |hit| length += hit.index * hit.distance).ok()?;
        length += (self.chief.before.origin - out.origin).dot(out.direction);
        let from_chief = point - DVec2::new(0.0, self.chief.image_height_mm);
        // The ray runs the other way here.
        Some(length + cosines.dot(from_chief))
    }
}

impl LensAt<'_> {
    /// The optical path differences of an object at infinity at an angle in rad from the axis, on a grid of `size`²
    /// points over its pupil; `None` where no light of it passes.
    ///
    /// The pupil's coordinates are the direction cosines at the sensor, so that frequencies on the sensor have their true
    /// scale off the axis, too.
    pub fn wavefront(&self, field_rad: f64, size: usize) -> Option<Wavefront> {
        let chief = self.chief_ray(field_rad)?;
        let direction = chief.before.direction;
        let rays = Rays { at: self, chief, across: [DVec3::X, DVec3::new(0.0, direction.z, -direction.y)] };
        let landed = DVec2::new(0.0, chief.image_height_mm);
        let (about, reach) = self.rear_opening(chief.image_height_mm);
        let seed = -chief.behind.direction.truncate();
        let passes = |cosines: DVec2| {
            cosines.length_squared() < 1.0
                && rays.landing(landed, cosines).and_then(|point| rays.path(point, cosines, Apertures::Clip)).is_some()
        };
        let region = Region::find(passes, seed, about, reach, DIRECTIONS)?;
        let [low, high] = region.bounds();
        // A rim that the grid just misses is found by half a cell more.
        let spacing = (high - low).max_element() / (size as f64 - 1.0);
        let first = 0.5 * (low + high) - 0.5 * spacing * (size as f64 - 1.0);
        let zero = rays.path(landed, seed, Apertures::Ignore)?;
        let mut path_mm = Vec::with_capacity(size * size);
        for row in 0..size {
            let mut start = landed;
            for column in 0..size {
                let cosines = first + spacing * DVec2::new(column as f64, row as f64);
                let point = if cosines.length_squared() < 1.0 { rays.landing(start, cosines) } else { None };
                // Neighbours land near each other.
                start = point.unwrap_or(landed);
                let path = point.and_then(|point| rays.path(point, cosines, Apertures::Clip));
                path_mm.push(path.map(|path| path - zero));
            }
        }
        path_mm.iter().any(Option::is_some).then_some(Wavefront {
            wavelength_nm: self.wavelength_nm,
            size,
            spacing,
            path_mm,
        })
    }
}

impl Wavefront {
    /// Root mean square of the path differences in waves, about the plane that fits them best: a tilt only moves the
    /// picture.
    pub fn rms_waves(&self) -> f64 {
        let levelled = self.levelled();
        let count = levelled.iter().flatten().count() as f64;
        let square = levelled.iter().flatten().map(|path| path * path).sum::<f64>() / count;
        square.sqrt() / (self.wavelength_nm * 1e-6)
    }

    /// W less its best plane.
    fn levelled(&self) -> Vec<Option<f64>> {
        let at = |i: usize| DVec2::new((i % self.size) as f64, (i / self.size) as f64);
        let known = || self.path_mm.iter().enumerate().filter_map(|(i, path)| path.map(|path| (at(i), path)));
        let count = known().count() as f64;
        let (middle, mean) = known().fold((DVec2::ZERO, 0.0), |(p, w), (point, path)| (p + point, w + path));
        let (middle, mean) = (middle / count, mean / count);
        // Normal equations of w = s·(x, y) about the means.
        let (mut squares, mut products) = (DMat2::ZERO, DVec2::ZERO);
        for (point, path) in known() {
            let d = point - middle;
            squares += DMat2::from_cols(d * d.x, d * d.y);
            products += d * (path - mean);
        }
        let tilt = if squares.determinant() > 0.0 { squares.inverse() * products } else { DVec2::ZERO };
        let level = |(i, path): (usize, &Option<f64>)| path.map(|path| path - mean - tilt.dot(at(i) - middle));
        self.path_mm.iter().enumerate().map(level).collect()
    }

    /// The picture of the point, |FT of exp(2πi·W/λ)|², moved to where the best plane of W is level: the tilt only says
    /// where it lies.
    pub fn point_spread(&self) -> PointSpread {
        let size = PADDING * self.size;
        let wavelength_mm = self.wavelength_nm * 1e-6;
        let mut field = vec![Complex64::default(); size * size];
        for (i, path) in self.levelled().into_iter().enumerate() {
            if let Some(path) = path {
                field[i / self.size * size + i % self.size] = Complex64::from_polar(1.0, TAU * path / wavelength_mm);
            }
        }
        let fft = FftPlanner::new().plan_fft_forward(size);
        // Rows, then columns: a transposition, twice over, leaves the order as it was.
        for _ in 0..2 {
            fft.process(&mut field);
            field = (0..size * size).map(|i| field[i % size * size + i / size]).collect();
        }
        let total: f64 = field.iter().map(Complex64::norm_sqr).sum();
        // Frequency 0 in the middle.
        let moved = |i: usize| (i + size - size / 2) % size;
        let energy = (0..size * size).map(|i| field[moved(i / size) * size + moved(i % size)].norm_sqr() / total);
        PointSpread { size, spacing_mm: wavelength_mm / (size as f64 * self.spacing), energy: energy.collect() }
    }
}

impl PointSpread {
    /// The modulation transfer at a frequency ν in cycles per mm along `axis`, a unit vector: |Σ E·exp(−2πi·ν·x)|.
    pub fn mtf(&self, axis: DVec2, frequency_per_mm: f64) -> f64 {
        let middle = (self.size / 2) as f64;
        let at = |i: usize| DVec2::new((i % self.size) as f64 - middle, (i / self.size) as f64 - middle);
        let phase = |i: usize| -TAU * frequency_per_mm * self.spacing_mm * at(i).dot(axis);
        let all = self.energy.iter().enumerate().map(|(i, energy)| DVec2::from_angle(phase(i)) * *energy);
        all.sum::<DVec2>().length()
    }
}
