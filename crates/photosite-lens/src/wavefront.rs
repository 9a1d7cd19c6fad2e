//! Optical path differences over the pupil of an object point, at infinity or nearer.
//! [`point_spread`](crate::point_spread) derives point spread functions from them.

use std::cell::Cell;

use glam::{DMat2, DVec2};

use crate::chief::ChiefRay;
use crate::profile::Travel;
use crate::region::Region;
use crate::spots::ObjectPoint;
use crate::trace::{Apertures, LensAt, Ray, Step};

/// Number of directions in which the edge of the pupil is searched for.
const DIRECTIONS: usize = 96;
/// Deviation from the object's direction, rad, at which Newton's method for the sensor point ends: the error of W is
/// its square times a length of the lens, some 1e-12 mm.
const TOLERANCE: f64 = 1e-7;
/// Largest number of Newton steps; fraction of the distance that a step may leave before derivatives are computed anew;
/// and number of times that a step is halved that comes no nearer, or leads past the lens.
const MOST_STEPS: usize = 30;
const SLOW: f64 = 0.2;
const HALVINGS: i32 = 8;
/// Number of strides from the chief ray's direction to one that is not reached at once.
const STRIDES: u32 = 8;
/// Step of the numerical derivatives, mm.
const STEP_MM: f64 = 1e-4;

/// Optical path differences of the light of an object point over the pupil, in image-side direction cosines.
#[derive(Clone, Debug)]
pub struct Wavefront {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Number of points along a side of the grid.
    pub size: usize,
    /// Direction cosines of the first point.
    pub first: DVec2,
    /// Spacing of the grid in direction cosines.
    pub spacing: f64,
    /// W at the points of the grid, mm, row by row (p fastest, q up), or, for cells cut by the edge of the pupil, in
    /// the middle of the part inside; `None` where no light of the cell around the point passes.
    pub path_mm: Vec<Option<f64>>,
    /// Fraction of each cell that lies in the pupil, from 0 to 1.
    pub covered: Vec<f64>,
    /// Direction cosines that W belongs to.
    pub cosines: Vec<DVec2>,
    /// Covered area, in cells, of cells whose ray was not found: 0 unless the lens folds its pupil.
    pub lost: f64,
    /// Landing points of the rays, mm; NaN where there is none.
    pub(crate) landing_mm: Vec<DVec2>,
    /// Path W of the chief ray, mm, which is subtracted.
    pub(crate) zero_mm: f64,
}

/// Search for the rays of one object point by their direction at the sensor.
pub(crate) struct Rays<'a> {
    pub(crate) at: &'a LensAt<'a>,
    chief: ChiefRay,
    object: ObjectPoint,
}

impl<'a> Rays<'a> {
    pub(crate) fn new(at: &'a LensAt<'a>, chief: ChiefRay, distance_mm: f64) -> Self {
        Self { at, chief, object: ObjectPoint::on(&chief, distance_mm) }
    }

    /// Landing point of the chief ray, mm.
    pub(crate) fn chief_landing(&self) -> DVec2 {
        DVec2::new(0.0, self.chief.image_height_mm)
    }

    /// Direction cosines at the sensor of the chief ray run outwards.
    pub(crate) fn chief_cosines(&self) -> DVec2 {
        -self.chief.behind.direction.truncate()
    }

    /// Angle by which the ray from a sensor point with some direction cosines misses the object, seen from the lens,
    /// rad.
    fn miss(&self, point: DVec2, cosines: DVec2) -> Option<DVec2> {
        let out = self.at.trace_out(self.at.ray_from_sensor(point, cosines), Apertures::Ignore).ok()?;
        let (direction, before) = (out.direction, self.chief.before);
        // Per distance, in the plane of the object across the chief ray.
        let closeness = self.object.distance_mm.recip();
        let from_chief = out.origin - before.origin;
        let along = 1.0 + closeness * from_chief.dot(before.direction);
        let miss = closeness * from_chief - direction * (along / direction.dot(before.direction));
        let [x, y] = self.object.across().map(|axis| miss.dot(axis));
        Some(DVec2::new(x, y))
    }

    /// Sensor point at which the object's light arrives with these direction cosines: from the first of some places
    /// that leads there, or else in strides from the chief ray's direction.
    fn landing(&self, starts: &[DVec2], cosines: DVec2, derivatives: &mut Option<DMat2>) -> Option<DVec2> {
        let found = starts.iter().find_map(|start| self.nearing(*start, cosines, derivatives));
        found.or_else(|| {
            let from = self.chief_cosines();
            let stride = |i: u32| from.lerp(cosines, f64::from(i) / f64::from(STRIDES));
            (1..=STRIDES).try_fold(self.chief_landing(), |point, i| self.nearing(point, stride(i), derivatives))
        })
    }

    /// Sensor point by Newton's method with the derivatives of a ray nearby, which are computed anew where convergence
    /// is poor. A step that still comes no nearer is halved: rays near the rim of fast lenses bend, and a whole step
    /// may lead to where there are none.
    fn nearing(&self, start: DVec2, cosines: DVec2, derivatives: &mut Option<DMat2>) -> Option<DVec2> {
        let mut point = start;
        let mut miss = self.miss(point, cosines)?;
        for _ in 0..MOST_STEPS {
            if miss.length() < TOLERANCE {
                return Some(point);
            }
            let (inverse, halvings) = match derivatives {
                Some(inverse) => (*inverse, 0),
                None => {
                    let along = |step: DVec2| Some((self.miss(point + step, cosines)? - miss) / STEP_MM);
                    let jacobian = DMat2::from_cols(along(DVec2::X * STEP_MM)?, along(DVec2::Y * STEP_MM)?);
                    (*derivatives.insert(jacobian.inverse()), HALVINGS)
                }
            };
            let nearer = (0..=halvings).find_map(|halving| {
                let next = point - inverse * miss * 0.5_f64.powi(halving);
                let miss_there = self.miss(next, cosines)?;
                (miss_there.length() < miss.length()).then_some((next, miss_there))
            });
            match nearer {
                Some((next, miss_there)) => {
                    if miss_there.length() > SLOW * miss.length() {
                        *derivatives = None;
                    }
                    (point, miss) = (next, miss_there);
                }
                None => {
                    *derivatives = None;
                    if halvings > 0 {
                        return None;
                    }
                }
            }
        }
        None
    }

    /// Path difference W: the optical path from a wave front of the object to the sensor less D·(landing − chief
    /// landing), D the direction there, mm. The wave front goes through the chief ray's point on the first surface. A
    /// ray that misses the object slightly has an error of second order, by Fermat's principle.
    pub(crate) fn path(&self, point: DVec2, cosines: DVec2, apertures: Apertures) -> Option<f64> {
        let ray = self.at.ray_from_sensor(point, cosines);
        let steps = (0..self.at.lens.surfaces().len()).rev().map(Step::refract);
        let mut length = 0.0;
        let out =
            self.at.trace(ray, Travel::ToScene, steps, apertures, |hit| length += hit.index * hit.distance).ok()?;
        let Ray { origin, direction } = self.chief.before;
        let from_chief = out.origin - origin;
        length += if self.object.distance_mm.is_infinite() {
            from_chief.dot(direction)
        } else {
            // The distance of the object from there less that from the chief ray's point: a difference of squares over a
            // sum, since both may be long.
            let r = self.object.distance_mm;
            let object = -direction * r;
            let sum = (object - from_chief).length() + r.abs();
            r.signum() * (from_chief - 2.0 * object).dot(from_chief) / sum
        };
        // The ray runs the other way here.
        Some(length + cosines.dot(point - self.chief_landing()))
    }

    /// Region of the directions at which light of the object passes every aperture, by the boundary in this number of
    /// directions: the boundary of the beam before the lens, traced through it.
    pub(crate) fn region(&self, directions: usize) -> Option<Region> {
        let beam = self.at.beam_of(self.object, directions)?;
        let behind =
            |point: DVec2| Some(-self.at.trace_in(beam.ray(point), Apertures::Ignore).ok()?.direction.truncate());
        let edge = (0..directions).filter_map(|i| behind(beam.region.boundary(i))).collect::<Vec<_>>();
        Region::of_boundary(behind(beam.region.centre)?, &edge, directions)
    }

    /// Landing point of light of a direction, regardless of apertures.
    pub(crate) fn landing_from_chief(&self) -> impl Fn(DVec2) -> Option<DVec2> {
        let near = Cell::new(None);
        move |cosines: DVec2| {
            let mut derivatives = near.get();
            let point = self.landing(&[self.chief_landing()], cosines, &mut derivatives);
            near.set(derivatives);
            point
        }
    }

    /// The path differences, to the chief ray's, on a grid of `size`² points between two corners, regardless of
    /// apertures. `cells` gives, for cells of a side, the covered fraction of the cell about some direction cosines,
    /// and the middle of that part.
    pub(crate) fn wavefront<Cell: Fn(DVec2) -> (f64, DVec2)>(
        &self,
        [low, high]: [DVec2; 2],
        size: usize,
        cells: impl FnOnce(f64) -> Cell,
    ) -> Option<Wavefront> {
        let spacing = (high - low).max_element() / (size as f64 - 1.0);
        let cell = cells(spacing);
        let first = 0.5 * (low + high) - 0.5 * spacing * (size as f64 - 1.0);
        let zero = self.path(self.chief_landing(), self.chief_cosines(), Apertures::Ignore)?;
        let mut wavefront = Wavefront {
            wavelength_nm: self.at.wavelength_nm,
            size,
            first,
            spacing,
            path_mm: vec![None; size * size],
            covered: vec![0.0; size * size],
            cosines: vec![DVec2::NAN; size * size],
            lost: 0.0,
            landing_mm: vec![DVec2::NAN; size * size],
            zero_mm: zero,
        };
        let mut derivatives = None;
        for number in 0..size * size {
            let point = first + spacing * DVec2::new((number % size) as f64, (number / size) as f64);
            let (covered, cosines) = cell(point);
            wavefront.cosines[number] = cosines;
            if covered == 0.0 {
                continue;
            }
            let starts = wavefront.near(number, self.chief_landing());
            let is_direction = cosines.length_squared() < 1.0;
            let point = if is_direction { self.landing(&starts, cosines, &mut derivatives) } else { None };
            let path = point.and_then(|point| Some((point, self.path(point, cosines, Apertures::Ignore)?)));
            match path {
                Some((point, path)) => {
                    wavefront.landing_mm[number] = point;
                    wavefront.path_mm[number] = Some(path - zero);
                    wavefront.covered[number] = covered;
                }
                None => wavefront.lost += covered,
            }
        }
        wavefront.path_mm.iter().any(Option::is_some).then_some(wavefront)
    }
}

impl LensAt<'_> {
    /// Optical path differences of an object at infinity at an angle in rad from the axis, on a grid of `size`² points
    /// over its pupil; `None` where no light of it passes.
    ///
    /// The pupil's coordinates are the direction cosines at the sensor, so that frequencies on the sensor have their true
    /// scale off the axis, too.
    pub fn wavefront(&self, field_rad: f64, size: usize) -> Option<Wavefront> {
        self.wavefront_of(self.chief_ray(field_rad)?, f64::INFINITY, size)
    }

    /// Optical path differences of an object on a chief ray at a distance from that ray's point on the first surface,
    /// mm: infinite for parallel light, below 0 for light that converges behind that point.
    pub fn wavefront_of(&self, chief: ChiefRay, distance_mm: f64, size: usize) -> Option<Wavefront> {
        let rays = Rays::new(self, chief, distance_mm);
        let region = rays.region(DIRECTIONS)?;
        rays.wavefront(region.bounds(), size, |side| region.cells(side))
    }
}

impl LensAt<'_> {
    /// Path differences of an object on a chief ray at a distance from that ray's point on the first surface, mm, by
    /// quadrature over its pupil; `None` where no light of it passes.
    pub fn path_differences(&self, chief: ChiefRay, distance_mm: f64) -> Option<PathDifferences> {
        let rays = Rays::new(self, chief, distance_mm);
        let (mut known, mut lost, mut whole) = (Vec::new(), 0.0, 0.0);
        let (mut near, mut derivatives) = (rays.chief_landing(), None);
        for (cosines, weight) in rays.region(DIRECTIONS)?.points() {
            whole += weight;
            let found = rays.landing(&[near, rays.chief_landing()], cosines, &mut derivatives);
            match found.and_then(|point| Some((point, rays.path(point, cosines, Apertures::Ignore)?))) {
                Some((point, path)) => {
                    near = point;
                    known.push((cosines, path, weight));
                }
                None => lost += weight,
            }
        }
        let plane = Plane::fit(&known)?;
        let square = |(cosines, path, weight): &(DVec2, f64, f64)| weight * (path - plane.at(*cosines)).powi(2);
        let rms_mm = (known.iter().map(square).sum::<f64>() / (whole - lost)).sqrt();
        Some(PathDifferences { rms_waves: rms_mm / (self.wavelength_nm * 1e-6), lost: lost / whole })
    }
}

impl Wavefront {
    /// Path differences W minus their best-fit plane.
    pub(crate) fn levelled(&self) -> Vec<Option<f64>> {
        let Some(plane) = self.plane(|number| self.covered[number]) else { return self.path_mm.clone() };
        let level = |(i, path): (usize, &Option<f64>)| path.map(|path| path - plane.at(self.cosines[i]));
        self.path_mm.iter().enumerate().map(level).collect()
    }

    /// Guesses for a landing point: the extrapolation of two neighbours of its row, those of its neighbours, and the
    /// chief ray's landing point.
    fn near(&self, number: usize, chief: DVec2) -> [DVec2; 4] {
        let known = |back: usize, is_inside: bool| {
            let place = if is_inside { number.checked_sub(back) } else { None };
            place.map(|place| self.landing_mm[place]).filter(|landing| landing.is_finite())
        };
        let column = number % self.size;
        let (left, below) = (known(1, column >= 1), known(self.size, true));
        let ahead = left.zip(known(2, column >= 2)).map(|(left, before)| 2.0 * left - before);
        let nearest = ahead.or(left).or(below).unwrap_or(chief);
        [nearest, left.unwrap_or(nearest), below.unwrap_or(nearest), chief]
    }

    /// Path difference W between the points of the grid, by Lagrange's cubics through four of them each way; `None`
    /// where one of the sixteen is missing.
    pub(crate) fn between(&self, cosines: DVec2) -> Option<f64> {
        self.row(cosines.y)?.at(cosines.x)
    }

    /// Row of W interpolated between those of the grid; `None` beyond them.
    pub(crate) fn row(&self, y: f64) -> Option<Row> {
        let (from, up) = four((y - self.first.y) / self.spacing, self.size)?;
        let path = |row: usize, column: usize| self.path_mm[(from + row) * self.size + column].unwrap_or(f64::NAN);
        let at = |column: usize| (0..4).map(|j| up[j] * path(j, column)).sum();
        Some(Row { first: self.first.x, spacing: self.spacing, path_mm: (0..self.size).map(at).collect() })
    }

    /// Largest distance of landing light from a place on the sensor, mm from the chief ray's landing point: the
    /// steepest slope of W against that of a plane, by the differences of neighbours that count.
    pub(crate) fn steepest_mm(&self, counts: impl Fn(DVec2) -> bool, tilt_mm: DVec2) -> f64 {
        let step = |i: usize, to: usize| Some((self.path_mm[to]? - self.path_mm[i]?) / self.spacing);
        let slope = |i: usize| {
            let is_inner = i % self.size + 1 < self.size && i / self.size + 1 < self.size && counts(self.cosines[i]);
            is_inner.then(|| Some(DVec2::new(step(i, i + 1)?, step(i, i + self.size)?)))?
        };
        (0..self.path_mm.len()).filter_map(slope).map(|slope| slope.distance(tilt_mm)).fold(0.0, f64::max)
    }

    /// Plane that fits W best by the weights of the grid's points; `None` where all are 0.
    pub(crate) fn plane(&self, weight: impl Fn(usize) -> f64) -> Option<Plane> {
        let of_point = |(i, path): (usize, &Option<f64>)| path.map(|path| (self.cosines[i], path, weight(i)));
        let known: Vec<_> = self.path_mm.iter().enumerate().filter_map(of_point).collect();
        Plane::fit(&known)
    }
}

/// Path differences W along a row of direction cosines, mm; NaN where missing.
pub(crate) struct Row {
    first: f64,
    spacing: f64,
    path_mm: Vec<f64>,
}

impl Row {
    /// Path difference W by the cubic through four points; `None` where one is missing.
    pub(crate) fn at(&self, x: f64) -> Option<f64> {
        let (from, across) = four((x - self.first) / self.spacing, self.path_mm.len())?;
        let path = self.path_mm[from..from + 4].iter().zip(across).map(|(path, weight)| weight * path).sum::<f64>();
        path.is_finite().then_some(path)
    }
}

/// Deviation of the wave front of a point, behind the lens, from a sphere about a point of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathDifferences {
    /// Root mean square of W in waves, about the best-fit plane: a tilt only moves the image.
    pub rms_waves: f64,
    /// Fraction of the pupil whose rays were not found: 0 unless the lens folds its pupil.
    pub lost: f64,
}

/// A plane over the pupil, mm.
pub(crate) struct Plane {
    middle: DVec2,
    mean: f64,
    /// Slope of the plane: the landing point of its light from the chief ray's, mm.
    pub(crate) tilt_mm: DVec2,
}

impl Plane {
    /// Plane that fits W best at places of the pupil, by their weights; `None` where all are 0.
    fn fit(known: &[(DVec2, f64, f64)]) -> Option<Self> {
        let total = known.iter().map(|(_, _, weight)| weight).sum::<f64>();
        if total <= 0.0 {
            return None;
        }
        let middle = known.iter().map(|(point, _, weight)| *point * *weight).sum::<DVec2>() / total;
        let mean = known.iter().map(|(_, path, weight)| path * weight).sum::<f64>() / total;
        // Normal equations of w = s·(x, y) about the means.
        let (mut squares, mut products) = (DMat2::ZERO, DVec2::ZERO);
        for (point, path, weight) in known {
            let d = *point - middle;
            squares += DMat2::from_cols(d * d.x, d * d.y) * *weight;
            products += d * (path - mean) * *weight;
        }
        let tilt_mm = if squares.determinant() > 0.0 { squares.inverse() * products } else { DVec2::ZERO };
        Some(Self { middle, mean, tilt_mm })
    }

    pub(crate) fn at(&self, cosines: DVec2) -> f64 {
        self.mean + self.tilt_mm.dot(cosines - self.middle)
    }
}

/// First of the four points around a place among `count`, and their weights; `None` where there are no four.
fn four(place: f64, count: usize) -> Option<(usize, [f64; 4])> {
    let from = place.floor() - 1.0;
    (from >= 0.0 && from + 4.0 <= count as f64).then(|| (from as usize, cubic_weights(place - from)))
}

/// Weights of the points 0 to 3 in the cubic through their values at `x`.
fn cubic_weights(x: f64) -> [f64; 4] {
    let [a, b, c, d] = [x, x - 1.0, x - 2.0, x - 3.0];
    [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0]
}

#[cfg(test)]
mod tests;
