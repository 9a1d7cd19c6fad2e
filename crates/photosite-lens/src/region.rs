//! Regions of a plane in which a test holds, such as the part of a pupil that passes every aperture.

use std::f64::consts::TAU;

use glam::DVec2;

/// Number of places along a radius, from outside in, at which the outermost passing point is searched for.
const PLACES: u32 = 24;
/// Precision of the boundary, relative to its distance from the centre.
pub(crate) const PRECISION: f64 = 1e-6;
/// Half-widths of the first search about the boundary of the direction before, relative to its distance from the
/// centre, widened where the boundary is not there.
const BRACKETS: [f64; 3] = [0.02, 0.08, 0.32];
/// Number of steps of the search for a boundary after which its interval is bisected.
const MOST_SECANTS: usize = 12;
/// Number of directions of a first look at a region, and margin of the later search over its result.
const FIRST_DIRECTIONS: usize = 16;
const BEYOND: f64 = 1.5;
/// Half of the Gauss–Legendre quadrature with eight points: distances from the middle of an interval of length 1, and
/// weights, on either side.
const GAUSS: [(f64, f64); 4] = [
    (0.091_717_321_247_824_9, 0.181_341_891_689_181),
    (0.262_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.398_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.480_144_928_248_768_15, 0.050_614_268_145_188_13),
];
/// Numbers of cells along a side of the grids in which a first passing point is searched for, from coarse to fine.
const GRIDS: [u32; 4] = [16, 48, 144, 432];

/// A region given by its boundary about a centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Centre, a point of the region.
    pub centre: DVec2,
    /// Units along x and y, about half the region's width and height. In these it is about round, so that evenly spaced
    /// directions meet the ends of a thin region as often as its sides.
    scale: DVec2,
    /// Distances of the boundary from the centre in these units, in evenly spaced directions, the first along x, then
    /// towards y.
    radii: Vec<f64>,
}

impl Region {
    /// Finds the region in which `depth` is 0 or more, as its boundary in `directions` directions about its middle. It
    /// lies within `reach` of `about`; `seed` is a point that may belong to it. `None` where no point of it is found.
    /// The more evenly `depth` falls through the boundary, the fewer steps the search takes; it may be infinite.
    ///
    /// Where the boundary is crossed more than once along a radius, the outermost crossing counts.
    pub fn find(
        depth: impl Fn(DVec2) -> f64,
        seed: DVec2,
        about: DVec2,
        reach: f64,
        directions: usize,
    ) -> Option<Self> {
        let passes = |point: DVec2| depth(point) >= 0.0;
        let inside = if passes(seed) { seed } else { first_inside(&passes, about, reach)? };
        // The middle of the boundary as seen from there, then of that as seen from its middle.
        let first = Self::about(&depth, inside, DVec2::ONE, (about - inside, reach), FIRST_DIRECTIONS);
        let look = |centre: DVec2, around: &Self, directions: usize| {
            let [low, high] = around.bounds();
            let scale = 0.5 * (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
            // From anywhere within it to its corners.
            let farthest = ((high - centre).max(centre - low) / scale).length();
            Self::about(&depth, centre, scale, (DVec2::ZERO, BEYOND * farthest), directions)
        };
        let better = |around: &Self| Some(around.centroid()).filter(|middle| passes(*middle)).unwrap_or(around.centre);
        let second = look(better(&first), &first, FIRST_DIRECTIONS);
        Some(look(better(&second), &second, directions))
    }

    /// Boundary about a point of the region, in given units, within a circle, whose middle is relative to the point.
    fn about(
        depth: &impl Fn(DVec2) -> f64,
        centre: DVec2,
        scale: DVec2,
        (about, reach): (DVec2, f64),
        directions: usize,
    ) -> Self {
        let depth = |place: DVec2| depth(centre + scale * place);
        let mut guess = None;
        let outermost = |i: usize| {
            let radius = outermost(&depth, DVec2::ZERO, angle(i, directions), guess, (about, reach), PRECISION);
            guess = Some(radius);
            radius
        };
        Self { centre, scale, radii: (0..directions).map(outermost).collect() }
    }

    /// Region about a centre with a boundary through consecutive points around it, as cubics of the angle through four
    /// of them; `None` where they do not go around it.
    pub(crate) fn of_boundary(centre: DVec2, points: &[DVec2], directions: usize) -> Option<Self> {
        let [low, high] = bounds(points.iter().copied());
        let scale = 0.5 * (high - low);
        let mut polar: Vec<(f64, f64)> = points
            .iter()
            .map(|point| (*point - centre) / scale)
            .map(|d| (d.to_angle().rem_euclid(TAU), d.length()))
            .collect();
        polar.sort_by(|a, b| a.0.total_cmp(&b.0));
        let count = polar.len();
        if count < 4 {
            return None;
        }
        // Number i of the points, which go on around.
        let at = |i: usize| (polar[i % count].0 + TAU * ((i / count) as f64 - 1.0), polar[i % count].1);
        let radius = |i: usize| {
            let angle = angle(i, directions);
            let next = count + polar.partition_point(|(known, _)| *known <= angle);
            let four = [next - 2, next - 1, next, next + 1].map(at);
            let weight = |j: usize| {
                let others = (0..4).filter(|k| *k != j);
                others.map(|k| (angle - four[k].0) / (four[j].0 - four[k].0)).product::<f64>()
            };
            (0..4).map(|j| weight(j) * four[j].1).sum::<f64>()
        };
        let radii: Vec<f64> = (0..directions).map(radius).collect();
        radii.iter().all(|radius| radius.is_finite()).then_some(Self { centre, scale, radii })
    }

    /// Area: ½·∫ρ² dφ by the rectangle rule.
    pub fn area(&self) -> f64 {
        let squares = self.radii.iter().map(|radius| radius * radius).sum::<f64>();
        0.5 * squares * TAU / self.radii.len() as f64 * self.scale.element_product()
    }

    /// Quadrature points of the region, with weights that add up to its area, sr or mm²: in each direction of its
    /// boundary, the Gauss–Legendre points, which are exact for polynomials of order 15 along the radius.
    pub fn points(&self) -> impl Iterator<Item = (DVec2, f64)> {
        let sector = TAU / self.radii.len() as f64 * self.scale.element_product();
        (0..self.radii.len()).flat_map(move |i| {
            let (radius, direction) = (self.radii[i], self.scale * DVec2::from_angle(angle(i, self.radii.len())));
            let at = move |part: f64, weight: f64| {
                (self.centre + direction * (part * radius), weight * part * radius * radius * sector)
            };
            let inner = GAUSS.into_iter().rev().map(|(x, weight)| (0.5 - x, weight));
            let outer = GAUSS.into_iter().map(|(x, weight)| (0.5 + x, weight));
            inner.chain(outer).map(move |(part, weight)| at(part, weight))
        })
    }

    /// Largest distance of the boundary from the centre.
    pub(crate) fn farthest(&self) -> f64 {
        (0..self.radii.len()).map(|i| self.boundary(i).distance(self.centre)).fold(0.0, f64::max)
    }

    /// Point of the boundary in direction `i`.
    pub fn boundary(&self, i: usize) -> DVec2 {
        self.centre + self.scale * DVec2::from_angle(angle(i, self.radii.len())) * self.radii[i]
    }

    /// Depth of a point inside the boundary along the radius, below 0 outside; between the directions the boundary is a
    /// cubic of the angle through four of them.
    pub(crate) fn depth(&self, point: DVec2) -> f64 {
        let from_centre = (point - self.centre) / self.scale;
        let directions = self.radii.len();
        let turn = from_centre.to_angle().rem_euclid(TAU) / TAU * directions as f64;
        let sector = (turn as usize).min(directions - 1);
        let t = turn - sector as f64;
        let [a, b, c, d] = [directions - 1, 0, 1, 2].map(|i| self.radii[(sector + i) % directions]);
        let boundary = b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
        // In place of units, mm or direction cosines along the radius; in the middle nothing says which way that is.
        let radius = from_centre.length();
        let unit = if radius > 0.0 { point.distance(self.centre) / radius } else { self.scale.min_element() };
        (boundary - radius) * unit
    }

    /// Fraction of a square of this side about a point that lies within the boundary, from 0 to 1, and the middle of
    /// that part, as if the boundary were a straight edge along the square: the errors at corners cancel along the
    /// boundary.
    pub(crate) fn cells(&self, side: f64) -> impl Fn(DVec2) -> (f64, DVec2) {
        // Most squares lie wholly on one side of all of the boundary, whose cubics reach beyond the radii they go through by an
        // eighth of the difference at most.
        let [least, most] = [f64::min, f64::max].map(|of| self.radii.iter().copied().reduce(of).unwrap_or(0.0));
        let half = 0.5 * side / self.scale.min_element();
        let [inner, outer] = [least - (most - least) / 8.0 - half, most + (most - least) / 8.0 + half];
        move |point: DVec2| {
            let radius = ((point - self.centre) / self.scale).length();
            if radius <= inner {
                return (1.0, point);
            }
            if radius >= outer {
                return (0.0, point);
            }
            let covered = (self.depth(point) / side + 0.5).clamp(0.0, 1.0);
            let inwards = (self.centre - point).normalize_or_zero();
            (covered, point + inwards * (0.5 * side * (1.0 - covered)))
        }
    }

    /// Corners of the smallest rectangle along the axes that holds the boundary.
    pub fn bounds(&self) -> [DVec2; 2] {
        bounds((0..self.radii.len()).map(|i| self.boundary(i)))
    }

    /// Centroid of the area: centre + ⅓·∫ρ³·(cos φ, sin φ) dφ over the area.
    fn centroid(&self) -> DVec2 {
        let directions = self.radii.len();
        let moment: DVec2 =
            (0..directions).map(|i| DVec2::from_angle(angle(i, directions)) * self.radii[i].powi(3)).sum::<DVec2>()
                * (TAU / directions as f64 / 3.0)
                * self.scale
                * self.scale.element_product();
        let area = self.area();
        if area > 0.0 { self.centre + moment / area } else { self.centre }
    }
}

/// Corners of the smallest rectangle along the axes that holds some points.
fn bounds(points: impl Iterator<Item = DVec2>) -> [DVec2; 2] {
    points.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], point| [low.min(point), high.max(point)])
}

/// Distance of the boundary from the centre along an angle in rad: the outermost place within a circle, its middle and
/// radius, at which `depth` is not below 0, to a relative precision; near a guess, where the boundary is there.
pub(crate) fn outermost(
    depth: &impl Fn(DVec2) -> f64,
    centre: DVec2,
    angle: f64,
    guess: Option<f64>,
    (about, reach): (DVec2, f64),
    precision: f64,
) -> f64 {
    let direction = DVec2::from_angle(angle);
    let at = |radius: f64| RadialDepth { radius, depth: depth(centre + direction * radius) };
    let guessed = guess.filter(|guess| *guess > 0.0).and_then(|guess| {
        BRACKETS.into_iter().find_map(|part| {
            let low = Some(at(guess * (1.0 - part))).filter(RadialDepth::is_inside)?;
            let high = Some(at(guess * (1.0 + part))).filter(|high| !high.is_inside())?;
            Some([low, high])
        })
    });
    let ends = guessed.unwrap_or_else(|| {
        // Where the radius leaves the circle.
        let offset = centre - about;
        let along = offset.dot(direction);
        let end = (along * along + reach * reach - offset.length_squared()).max(0.0).sqrt() - along;
        let place = |place: u32| end * f64::from(place) / f64::from(PLACES);
        let mut high = RadialDepth { radius: place(PLACES + 1), depth: f64::NEG_INFINITY };
        for i in (1..=PLACES).rev() {
            let low = at(place(i));
            if low.is_inside() {
                return [low, high];
            }
            high = low;
        }
        [at(0.0), high]
    });
    edge(at, ends, precision)
}

/// A place along a radius, and its depth inside, in any measure; below 0 outside.
#[derive(Clone, Copy)]
struct RadialDepth {
    radius: f64,
    depth: f64,
}

impl RadialDepth {
    fn is_inside(&self) -> bool {
        self.depth >= 0.0
    }
}

/// Radius at which depths fall through 0 between a place inside and one outside, from inside, to a relative precision:
/// by the Illinois method, or by bisection where depths are infinite.
fn edge(at: impl Fn(f64) -> RadialDepth, [mut low, mut high]: [RadialDepth; 2], precision: f64) -> f64 {
    for step in 0.. {
        let width = high.radius - low.radius;
        let least = 0.5 * precision * high.radius;
        if width <= 2.0 * least {
            break;
        }
        let part = if step < MOST_SECANTS { low.depth / (low.depth - high.depth) } else { 0.5 };
        let part = if part.is_finite() { part } else { 0.5 };
        let next = at((low.radius + part * width).clamp(low.radius + least, high.radius - least));
        // The end that stays counts half as much from now on.
        if next.is_inside() {
            low = next;
            high.depth *= 0.5;
        } else {
            high = next;
            low.depth *= 0.5;
        }
    }
    low.radius
}

/// Infinite depth, for a test that only tells inside from outside.
pub(crate) fn depth_of(is_inside: bool) -> f64 {
    if is_inside { f64::INFINITY } else { f64::NEG_INFINITY }
}

/// Angle of direction `i` of `directions`, rad.
fn angle(i: usize, directions: usize) -> f64 {
    TAU * i as f64 / directions as f64
}

/// First passing point, by ever finer grids over the square about the circle.
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

    /// Intersection of two circles, to a hundredth of their width: |S| where two rims leave little.
    #[test]
    fn a_thin_crescent_has_its_area() {
        let radius = 1.0;
        for width in [0.5, 0.1, 0.01] {
            let apart = DVec2::new(0.0, radius - 0.5 * width);
            let depth = |point: DVec2| radius - point.distance(apart).max(point.distance(-apart));
            let region = Region::find(depth, DVec2::new(0.1, 0.0), DVec2::ZERO, 1.0, 90).expect("a crescent");
            let half = (apart.y / radius).acos();
            let expected = 2.0 * radius * radius * (half - half.sin() * half.cos());
            // Nearly of parabolas, 1 − x² where both half axes are 1: ρ² turns by 2 at each end, which the rectangle rule sees as
            // an error of h²/12·2, of ½·∫ρ² = 8/3 in all.
            let bound = (TAU / 90.0).powi(2) / 12.0 * 2.0 / (8.0 / 3.0);
            assert!((region.area() / expected - 1.0).abs() < bound, "{width}: {} for {expected}", region.area());
        }
    }

    #[test]
    fn a_disk_off_the_seed_is_found_with_its_area() {
        let (middle, radius) = (DVec2::new(0.3, -0.2), 0.05);
        let depth = |point: DVec2| radius - point.distance(middle);
        let region = Region::find(depth, DVec2::ZERO, DVec2::ZERO, 0.6, 90).expect("a disk");
        assert!(region.centre.distance(middle) < 1e-3, "{region:?}");
        // The rectangle rule integrates the harmonics of ρ² exactly; what is left is the precision of ρ.
        let expected = std::f64::consts::PI * radius * radius;
        assert!((region.area() / expected - 1.0).abs() < 2.0 * PRECISION, "{}", region.area() / expected);
        // ∫|x|² about the middle is ½·π·R⁴, whose order 4 is far below 15.
        let second: f64 = region.points().map(|(point, weight)| weight * point.distance_squared(middle)).sum();
        assert!((second / (0.5 * std::f64::consts::PI * radius.powi(4)) - 1.0).abs() < 4.0 * PRECISION, "{second}");
        let [low, high] = region.bounds();
        assert!((low - (middle - radius)).abs().max_element() < 1e-3 * radius);
        assert!((high - (middle + radius)).abs().max_element() < 1e-3 * radius);
        assert_eq!(Region::find(|_| -1.0, DVec2::ZERO, DVec2::ZERO, 1.0, 8), None);
    }
}
