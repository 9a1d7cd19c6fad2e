//! Convex polygons whose sides face fixed directions, each given by its support function.
//!
//! The polygon that holds a region most tightly reaches as far as the region does: h(n) = max x·n over its points x,
//! the region's support function. Polygons are interpolated by interpolating these values: between two states of a
//! region that moves, grows or deforms lies the mixture of both, corner by corner.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;

use crate::region::{depth_of, outermost};

/// Number of sides of a polygon. Around a circle, 16 sides have 1.3 % more area.
pub(crate) const SIDES: usize = 16;
/// Number of directions from the centre in which the boundary of one half of a region is searched for, and number of
/// steps of the search for the farthest point between them.
const DIRECTIONS: usize = 32;
const STEPS: u32 = 4;
/// Precision of the boundary, relative to its distance from the centre.
const PRECISION: f64 = 1e-4;

/// A convex polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SupportPolygon {
    /// Support function h(n) in the directions n(0), n(1) …, the first along x, then towards y.
    pub(crate) reach: [f64; SIDES],
}

/// Outward normal n(i) of a side.
fn normal(side: usize) -> DVec2 {
    DVec2::from_angle(TAU * side as f64 / SIDES as f64)
}

impl SupportPolygon {
    /// Polygon around all points that pass at any of some wavelengths. They are their own mirror image in the y axis,
    /// lie about a `centre` on it, and within a circle, its middle and radius. `passes` takes the number of a
    /// wavelength and a point.
    pub(crate) fn around(
        passes: impl Fn(usize, DVec2) -> bool,
        wavelengths: usize,
        centre: f64,
        circle: (DVec2, f64),
    ) -> Self {
        let centre = DVec2::new(0.0, centre);
        let mut reach = [f64::NEG_INFINITY; SIDES];
        for wavelength in 0..wavelengths {
            let depth = |point| depth_of(passes(wavelength, point));
            let step = PI / DIRECTIONS as f64;
            let boundary = |angle: f64, guess: Option<f64>| {
                let radius = outermost(&depth, centre, angle, guess, circle, PRECISION);
                (radius, centre + DVec2::from_angle(angle) * radius)
            };
            // From −y to +y: the other half is its mirror image.
            let mut found = Vec::with_capacity(DIRECTIONS + 1);
            let mut guess = None;
            for i in 0..=DIRECTIONS {
                let angle = step * i as f64 - FRAC_PI_2;
                let (radius, point) = boundary(angle, guess);
                guess = Some(radius);
                found.push((angle, radius, point));
            }
            for side in (0..=SIDES / 4).chain(3 * SIDES / 4..SIDES) {
                let normal = normal(side);
                let farther =
                    |a: &&(f64, f64, DVec2), b: &&(f64, f64, DVec2)| a.2.dot(normal).total_cmp(&b.2.dot(normal));
                let Some(&(mut angle, mut radius, point)) = found.iter().max_by(farther) else { continue };
                // A corner between two directions reaches farther
                let (mut most, mut step) = (point.dot(normal), 0.5 * step);
                for _ in 0..STEPS {
                    let aside = [angle - step, angle + step].map(|angle| (angle, boundary(angle, Some(radius))));
                    for (there, (radius_there, point)) in aside {
                        if point.dot(normal) > most {
                            (most, angle, radius) = (point.dot(normal), there, radius_there);
                        }
                    }
                    step *= 0.5;
                }
                reach[side] = reach[side].max(most);
                let mirrored = (SIDES + SIDES / 2 - side) % SIDES;
                reach[mirrored] = reach[side];
            }
        }
        Self { reach }
    }

    /// Polygon with all sides moved: along y, and outwards.
    #[must_use]
    pub(crate) fn moved(&self, along_y: f64, outwards: f64) -> Self {
        Self { reach: std::array::from_fn(|side| self.reach[side] + along_y * normal(side).y + outwards) }
    }

    /// Mixture of polygons by weights that add up to 1.
    pub(crate) fn mixed(all: &[(&Self, f64)]) -> Self {
        Self {
            reach: std::array::from_fn(|side| all.iter().map(|(polygon, weight)| weight * polygon.reach[side]).sum()),
        }
    }

    /// Middle of the extent along y.
    pub(crate) fn centre(&self) -> f64 {
        0.5 * (self.reach[SIDES / 4] - self.reach[3 * SIDES / 4])
    }

    /// Half of the larger extent, along x or y.
    pub(crate) fn radius(&self) -> f64 {
        self.reach[0].max(0.5 * (self.reach[SIDES / 4] + self.reach[3 * SIDES / 4]))
    }

    /// Largest distance by which another polygon reaches beyond this one.
    pub(crate) fn lacks(&self, other: &Self) -> f64 {
        (0..SIDES).map(|side| other.reach[side] - self.reach[side]).fold(0.0, f64::max)
    }

    /// Corner between a side and the next one.
    fn corner(&self, side: usize) -> DVec2 {
        let (sin, cos) = (TAU / SIDES as f64).sin_cos();
        let (here, next) = (self.reach[side], self.reach[(side + 1) % SIDES]);
        normal(side) * here + normal(side).perp() * ((next - here * cos) / sin)
    }

    /// Whether a point lies in the polygon.
    pub(crate) fn contains(&self, point: DVec2) -> bool {
        (0..SIDES).all(|side| point.dot(normal(side)) <= self.reach[side])
    }

    /// Samples a point uniformly over the area, and returns the area with it; `None` where it is 0.
    pub(crate) fn sample(&self, [u, v]: [f64; 2]) -> Option<(DVec2, f64)> {
        // Triangles from the first corner
        let corners: [DVec2; SIDES] = std::array::from_fn(|side| self.corner(side));
        let twice_area = |i: usize| (corners[i] - corners[0]).perp_dot(corners[i + 1] - corners[0]).max(0.0);
        let whole: f64 = (1..SIDES - 1).map(twice_area).sum();
        let mut left = u * whole;
        let mut i = 1;
        while i < SIDES - 2 && left >= twice_area(i) {
            left -= twice_area(i);
            i += 1;
        }
        let within = (left / twice_area(i)).clamp(0.0, 1.0);
        let point = corners[0].lerp(corners[i].lerp(corners[i + 1], within), v.sqrt());
        (whole > 0.0).then_some((point, 0.5 * whole))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lens-shaped intersection of two circles, with corners left and right.
    fn passes(_: usize, point: DVec2) -> bool {
        [-0.5, 0.5].iter().all(|y| (point - DVec2::new(0.0, 2.0 + y)).length() <= 1.0)
    }

    fn around() -> SupportPolygon {
        SupportPolygon::around(passes, 1, 2.1, (DVec2::new(0.0, 2.1), 3.0))
    }

    #[test]
    fn a_polygon_reaches_as_far_as_its_region() {
        let polygon = around();
        // The corners at ±√(1 − ¼).
        for (side, expected) in
            [(0, 0.75_f64.sqrt()), (SIDES / 4, 2.5), (SIDES / 2, 0.75_f64.sqrt()), (3 * SIDES / 4, -1.5)]
        {
            assert!((polygon.reach[side] - expected).abs() < 1e-3, "{side}: {} {expected}", polygon.reach[side]);
        }
        assert!((polygon.centre() - 2.0).abs() < 1e-3 && (polygon.radius() - 0.866).abs() < 1e-3);
        let moved = polygon.moved(0.5, 0.1);
        assert!((moved.lacks(&polygon.moved(0.5, 0.3)) - 0.2).abs() < 1e-12 && polygon.lacks(&polygon) == 0.0);
        assert!(moved.contains(DVec2::new(0.9, 2.5)) && !moved.contains(DVec2::new(0.9, 1.6)));
        assert!(SupportPolygon::mixed(&[(&polygon, 0.5), (&moved, 0.5)]).lacks(&polygon.moved(0.25, 0.05)) < 1e-12);
    }

    #[test]
    fn points_of_a_polygon_fill_it_evenly() {
        let polygon = around();
        let n = 400;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
        let drawn = |i: i32| polygon.sample([at(i % n), at(i / n)]).expect("an area");
        let all: Vec<(DVec2, f64)> = (0..n * n).map(drawn).collect();
        assert!(all.iter().all(|(point, _)| polygon.moved(0.0, 1e-12).contains(*point)));
        // By the midpoint rule over a square.
        let inside = |x: std::ops::Range<f64>| {
            let place = |i: i32| DVec2::new(x.start + (x.end - x.start) * at(i % n), 1.0 + 2.0 * at(i / n));
            let cell = 2.0 * (x.end - x.start) / f64::from(n * n);
            (0..n * n).filter(|i| polygon.contains(place(*i))).count() as f64 * cell
        };
        let area = inside(-1.0..1.0);
        assert!((all[0].1 / area - 1.0).abs() < 3e-3, "{} {area}", all[0].1);
        let right = all.iter().filter(|(point, _)| point.x > 0.4).count() as f64 / f64::from(n * n);
        assert!((right - inside(0.4..1.0) / area).abs() < 3e-3, "{right}");
    }
}
