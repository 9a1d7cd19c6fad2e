//! Regions of a plane in which some test holds: the part of a pupil that passes every aperture.

use std::f64::consts::TAU;

use glam::DVec2;

/// Places along a radius, from outside in, at which the outermost point that passes is looked for.
const PLACES: u32 = 24;
/// The boundary is found to this part of its distance from the centre.
pub(crate) const PRECISION: f64 = 1e-6;
/// How far from the boundary of the direction before the next one is looked for at first, and farther where it is not
/// there.
const BRACKETS: [f64; 3] = [0.02, 0.08, 0.32];
/// Directions of a first look at a region, and how much farther than that the boundary is looked for then.
const FIRST_DIRECTIONS: usize = 16;
const BEYOND: f64 = 1.5;
/// Cells along a side of the grids in which a first point that passes is looked for, from coarse to fine.
const GRIDS: [u32; 4] = [16, 48, 144, 432];

/// A region given by its boundary about a centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The centre, which belongs to it.
    pub centre: DVec2,
    /// Distance of the boundary from the centre in as many directions, the first along x, then towards y.
    pub radii: Vec<f64>,
}

impl Region {
    /// The region in which `passes` holds, as its boundary in `directions` directions about its middle. It lies within
    /// `reach` of `about`; `seed` is a point that may belong to it. `None` where no point is found that does.
    ///
    /// Where the boundary is crossed more than once along a radius, the outermost crossing counts.
    pub fn find(
        passes: impl Fn(DVec2) -> bool,
        seed: DVec2,
        about: DVec2,
        reach: f64,
        directions: usize,
    ) -> Option<Self> {
        let inside = if passes(seed) { seed } else { first_inside(&passes, about, reach)? };
        // The middle of the boundary as seen from there, then of that as seen from its middle.
        let first = Self::about(&passes, inside, about, reach, FIRST_DIRECTIONS);
        let look = |centre: DVec2, around: &Self, directions: usize| {
            let farthest = around.radii.iter().fold(0.0_f64, |most, radius| most.max(*radius));
            let reach = BEYOND * (farthest + centre.distance(around.centre));
            Self::about(&passes, centre, centre, reach, directions)
        };
        let better = |around: &Self| Some(around.centroid()).filter(|middle| passes(*middle)).unwrap_or(around.centre);
        let second = look(better(&first), &first, FIRST_DIRECTIONS);
        Some(look(better(&second), &second, directions))
    }

    /// The boundary about a point that belongs to the region.
    fn about(passes: &impl Fn(DVec2) -> bool, centre: DVec2, about: DVec2, reach: f64, directions: usize) -> Self {
        let mut guess = None;
        let outermost = |i: usize| {
            let radius = outermost(passes, centre, angle(i, directions), guess, (about, reach), PRECISION);
            guess = Some(radius);
            radius
        };
        Self { centre, radii: (0..directions).map(outermost).collect() }
    }

    /// Area: ½·∫ρ² dφ by the rectangle rule.
    pub fn area(&self) -> f64 {
        0.5 * self.radii.iter().map(|radius| radius * radius).sum::<f64>() * TAU / self.radii.len() as f64
    }

    /// A point of its boundary.
    pub fn boundary(&self, i: usize) -> DVec2 {
        self.centre + DVec2::from_angle(angle(i, self.radii.len())) * self.radii[i]
    }

    /// How far inside the boundary a point is along the radius, below 0 outside; between the directions the boundary is a
    /// cubic of the angle through four of them.
    pub(crate) fn depth(&self, point: DVec2) -> f64 {
        let from_centre = point - self.centre;
        let directions = self.radii.len();
        let turn = from_centre.to_angle().rem_euclid(TAU) / TAU * directions as f64;
        let sector = (turn as usize).min(directions - 1);
        let t = turn - sector as f64;
        let [a, b, c, d] = [directions - 1, 0, 1, 2].map(|i| self.radii[(sector + i) % directions]);
        let boundary = b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
        boundary - from_centre.length()
    }

    /// How much of a square of this side about a point lies within the boundary, from 0 to 1, and the middle of that part,
    /// as if the boundary were a straight edge along the square: what the corners get wrong evens out along the boundary.
    pub(crate) fn cell(&self, point: DVec2, side: f64) -> (f64, DVec2) {
        let covered = (self.depth(point) / side + 0.5).clamp(0.0, 1.0);
        let inwards = (self.centre - point).normalize_or_zero();
        (covered, point + inwards * (0.5 * side * (1.0 - covered)))
    }

    /// Corners of the smallest rectangle along the axes that holds the boundary.
    pub fn bounds(&self) -> [DVec2; 2] {
        let all = (0..self.radii.len()).map(|i| self.boundary(i));
        all.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], point| [low.min(point), high.max(point)])
    }

    /// The mean of its area: centre + ⅓·∫ρ³·(cos φ, sin φ) dφ over the area.
    fn centroid(&self) -> DVec2 {
        let directions = self.radii.len();
        let moment: DVec2 =
            (0..directions).map(|i| DVec2::from_angle(angle(i, directions)) * self.radii[i].powi(3)).sum::<DVec2>()
                * (TAU / directions as f64 / 3.0);
        let area = self.area();
        if area > 0.0 { self.centre + moment / area } else { self.centre }
    }
}

/// Distance of the boundary from the centre along an angle in rad: the outermost place within a circle, its middle and
/// radius, that passes, to some part of it; near a guess, where it is there.
pub(crate) fn outermost(
    passes: &impl Fn(DVec2) -> bool,
    centre: DVec2,
    angle: f64,
    guess: Option<f64>,
    (about, reach): (DVec2, f64),
    precision: f64,
) -> f64 {
    let direction = DVec2::from_angle(angle);
    let is_inside = |radius: f64| passes(centre + direction * radius);
    let guessed = guess.filter(|guess| *guess > 0.0).and_then(|guess| {
        let around = BRACKETS.map(|part| (guess * (1.0 - part), guess * (1.0 + part)));
        around.into_iter().find(|(low, high)| is_inside(*low) && !is_inside(*high))
    });
    let (mut low, mut high) = guessed.unwrap_or_else(|| {
        // Where the radius leaves the circle.
        let offset = centre - about;
        let along = offset.dot(direction);
        let end = (along * along + reach * reach - offset.length_squared()).max(0.0).sqrt() - along;
        let at = |place: u32| end * f64::from(place) / f64::from(PLACES);
        let last = (1..=PLACES).rev().find(|&place| is_inside(at(place))).unwrap_or(0);
        (at(last), at(last + 1))
    });
    while high - low > precision * high {
        let middle = 0.5 * (low + high);
        if is_inside(middle) { low = middle } else { high = middle }
    }
    low
}

/// The direction of number i of some, rad.
fn angle(i: usize, directions: usize) -> f64 {
    TAU * i as f64 / directions as f64
}

/// A point that passes, by ever finer grids over the square about the circle.
fn first_inside(passes: &impl Fn(DVec2) -> bool, about: DVec2, reach: f64) -> Option<DVec2> {
    GRIDS.iter().find_map(|&cells| {
        let at = |i: u32| reach * (2.0 * (f64::from(i) + 0.5) / f64::from(cells) - 1.0);
        let all = (0..cells * cells).map(|i| about + DVec2::new(at(i % cells), at(i / cells)));
        // The middle one of those that pass is safer than the first.
        let inside: Vec<DVec2> = all.filter(|point| passes(*point)).collect();
        inside.get(inside.len() / 2).copied()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_off_the_seed_is_found_with_its_area() {
        let (middle, radius) = (DVec2::new(0.3, -0.2), 0.05);
        let passes = |point: DVec2| point.distance(middle) <= radius;
        let region = Region::find(passes, DVec2::ZERO, DVec2::ZERO, 0.6, 90).expect("a disk");
        assert!(region.centre.distance(middle) < 1e-3, "{region:?}");
        // The rectangle rule integrates the harmonics of ρ² exactly; what is left is the precision of ρ.
        let expected = std::f64::consts::PI * radius * radius;
        assert!((region.area() / expected - 1.0).abs() < 2.0 * PRECISION, "{}", region.area() / expected);
        let [low, high] = region.bounds();
        assert!((low - (middle - radius)).abs().max_element() < 1e-3 * radius);
        assert!((high - (middle + radius)).abs().max_element() < 1e-3 * radius);
        assert_eq!(Region::find(|_| false, DVec2::ZERO, DVec2::ZERO, 1.0, 8), None);
    }
}
