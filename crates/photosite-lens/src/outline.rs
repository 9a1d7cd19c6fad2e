//! Outlines of pupils: a boundary about a centre, and a containing polygon from which points are drawn.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;

use crate::region::{PRECISION, depth_of, outermost};

/// Number of corners of a polygon.
pub(crate) const CORNERS: usize = 64;
/// Number of directions per corner in which the boundary is searched for.
const FINER: usize = 2;
/// Margin of polygons over the found boundary, as a factor. Between the directions and the heights of a table a smooth
/// boundary bulges by less; 1 % let 8e-4 of the light of some lenses leak out.
pub(crate) const MARGIN: f64 = 1.02;

/// A boundary about a centre on the y axis.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    pub(crate) centre: f64,
    /// Distances from the centre to the corners, the first along x, then towards y.
    pub(crate) radii: Vec<f64>,
}

/// A polygon as triangles about a centre.
#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    centre: DVec2,
    /// Corners relative to the centre.
    corners: Vec<DVec2>,
    /// Cumulative areas of the triangles.
    areas: Vec<f64>,
    /// Guide table: for each of as many equal parts of the whole area, the triangle in which it starts.
    starts: Vec<u8>,
    area: f64,
}

impl Outline {
    /// Number of directions in which boundaries are searched for, the first along x, then towards y.
    pub(crate) const DIRECTIONS: usize = FINER * CORNERS;

    /// Boundary about a centre on the y axis of all points that pass at any of some wavelengths, within a circle, its
    /// middle and radius; it is its own mirror image. `passes` takes the number of a wavelength and a point.
    pub(crate) fn of(
        passes: impl Fn(usize, DVec2) -> bool,
        wavelengths: usize,
        centre: f64,
        circle: (DVec2, f64),
    ) -> Self {
        // From −y to +y: the other half is its mirror image.
        let half = FINER * CORNERS / 2;
        let mut fine = vec![0.0_f64; half + 1];
        for wavelength in 0..wavelengths {
            let depth = |point| depth_of(passes(wavelength, point));
            let mut guess = None;
            for (i, most) in fine.iter_mut().enumerate() {
                let angle = PI * i as f64 / half as f64 - FRAC_PI_2;
                let radius = outermost(&depth, DVec2::new(0.0, centre), angle, guess, circle, PRECISION);
                guess = Some(radius);
                *most = most.max(radius);
            }
        }
        let quarter = half / 2;
        let whole = |i: usize| {
            let from_below = (i + quarter) % (2 * half);
            fine[from_below.min(2 * half - from_below)]
        };
        let whole: Vec<f64> = (0..2 * half).map(whole).collect();
        Self { centre, radii: enclosing(&whole) }
    }

    /// Angle, rad, and distance from the centre of the boundary in one of the directions.
    pub(crate) fn boundary(&self, number: usize) -> (f64, f64) {
        let angle = TAU * number as f64 / Self::DIRECTIONS as f64;
        let sector = number / FINER;
        if number.is_multiple_of(FINER) {
            return (angle, self.radii[sector]);
        }
        let next = (sector + 1) % CORNERS;
        let edge = (direction(sector) * self.radii[sector], direction(next) * self.radii[next]);
        (angle, reach(edge, DVec2::from_angle(angle)))
    }

    /// Outline clipped to another boundary, which is given in all directions and widened by the factor `wider`.
    pub(crate) fn within(&self, boundary: &[f64], wider: f64) -> Self {
        let enclosed = enclosing(boundary);
        let radii = self.radii.iter().zip(&enclosed).map(|(own, other)| own.min(other * wider)).collect();
        Self { centre: self.centre, radii }
    }

    /// Interpolation between two outlines.
    pub(crate) fn between(low: &Self, high: &Self, t: f64) -> Self {
        let lerp = |a: f64, b: f64| a + t * (b - a);
        Self {
            centre: lerp(low.centre, high.centre),
            radii: low.radii.iter().zip(&high.radii).map(|(a, b)| lerp(*a, *b)).collect(),
        }
    }

    /// Union of outlines with the same centre.
    pub(crate) fn union(all: &[Self]) -> Option<Self> {
        let (first, others) = all.split_first()?;
        let mut union = first.clone();
        for other in others {
            union.radii.iter_mut().zip(&other.radii).for_each(|(most, radius)| *most = most.max(*radius));
        }
        Some(union)
    }

    /// Widens outlines until the interpolation halfway between them contains the outline found there.
    pub(crate) fn widen_to(around: &mut [&mut Self], middle: &Self) {
        let mut between = Self { centre: 0.0, radii: vec![0.0; CORNERS] };
        let part = 1.0 / around.len() as f64;
        for outline in around.iter() {
            between.centre += part * outline.centre;
            between.radii.iter_mut().zip(&outline.radii).for_each(|(sum, radius)| *sum += part * radius);
        }
        let shift = DVec2::new(0.0, middle.centre - between.centre);
        let polygon = Polygon::of(&between);
        for (i, radius) in middle.radii.iter().enumerate() {
            let corner = shift + direction(i) * *radius;
            let sector = polygon.sector(corner);
            let factor = corner.length() / polygon.reach(sector, corner);
            if factor > 1.0 {
                for j in [sector, (sector + 1) % CORNERS] {
                    around.iter_mut().for_each(|outline| outline.radii[j] *= factor);
                }
            }
        }
    }
}

/// Unit direction of a corner from the centre.
pub(crate) fn direction(corner: usize) -> DVec2 {
    DVec2::from_angle(TAU * corner as f64 / CORNERS as f64)
}

/// Distances to the corners of a polygon that contains a boundary found in `FINER` directions for each corner.
fn enclosing(fine: &[f64]) -> Vec<f64> {
    let mut radii: Vec<f64> = fine.iter().step_by(FINER).copied().collect();
    for (i, radius) in fine.iter().enumerate() {
        let (sector, next) = (i / FINER, (i / FINER + 1) % CORNERS);
        let angle = TAU * i as f64 / fine.len() as f64;
        let point = DVec2::from_angle(angle) * *radius;
        let edge = (direction(sector) * radii[sector], direction(next) * radii[next]);
        let reach = reach(edge, point);
        if *radius > reach && reach > 0.0 {
            radii[sector] *= radius / reach;
            radii[next] *= radius / reach;
        }
    }
    radii.iter().map(|radius| radius * MARGIN).collect()
}

/// Distance from the origin to an edge in the direction of a point.
fn reach((a, b): (DVec2, DVec2), point: DVec2) -> f64 {
    let direction = point.normalize_or_zero();
    let along = b - a;
    let crossing = direction.perp_dot(along);
    if crossing == 0.0 { a.length() } else { a.perp_dot(along) / crossing }
}

impl Polygon {
    pub(crate) fn empty() -> Self {
        Self { centre: DVec2::ZERO, corners: Vec::new(), areas: Vec::new(), starts: Vec::new(), area: 0.0 }
    }

    fn of(outline: &Outline) -> Self {
        Self {
            centre: DVec2::new(0.0, outline.centre),
            corners: outline.radii.iter().enumerate().map(|(i, radius)| direction(i) * *radius).collect(),
            ..Self::empty()
        }
    }

    /// Polygon that contains two outlines; `None` where they are empty.
    pub(crate) fn new(low: &Outline, high: &Outline) -> Option<Self> {
        let half = 0.5 * (high.centre - low.centre);
        let wider = |(a, b): (&f64, &f64)| a.max(*b) + half.abs();
        let radii: Vec<f64> = low.radii.iter().zip(&high.radii).map(wider).collect();
        let mut polygon = Self::of(&Outline { centre: low.centre + half, radii });
        let mut area = 0.0;
        for i in 0..CORNERS {
            area += 0.5 * polygon.corners[i].perp_dot(polygon.corners[(i + 1) % CORNERS]);
            polygon.areas.push(area);
        }
        polygon.area = area;
        let start = |part: usize| {
            let before = area * part as f64 / CORNERS as f64;
            polygon.areas.partition_point(|up_to| *up_to <= before).min(CORNERS - 1) as u8
        };
        polygon.starts = (0..CORNERS).map(start).collect();
        (area > 0.0).then_some(polygon)
    }

    pub(crate) fn area(&self) -> f64 {
        self.area
    }

    fn edge(&self, sector: usize) -> (DVec2, DVec2) {
        (self.corners[sector], self.corners[(sector + 1) % CORNERS])
    }

    /// Triangle whose angle contains a point relative to the centre.
    fn sector(&self, point: DVec2) -> usize {
        let turn = point.to_angle().rem_euclid(TAU) / TAU;
        ((turn * CORNERS as f64) as usize).min(CORNERS - 1)
    }

    fn reach(&self, sector: usize, point: DVec2) -> f64 {
        reach(self.edge(sector), point)
    }

    pub(crate) fn contains(&self, cosines: DVec2) -> bool {
        let point = cosines - self.centre;
        !self.areas.is_empty() && point.length() <= self.reach(self.sector(point), point)
    }

    /// Samples a point uniformly over the area: a triangle by its area, then a point of the triangle.
    pub(crate) fn sample(&self, [u, v]: [f64; 2]) -> DVec2 {
        let target = u * self.area;
        let mut sector = usize::from(self.starts[((u * CORNERS as f64) as usize).min(CORNERS - 1)]);
        while sector < CORNERS - 1 && self.areas[sector] <= target {
            sector += 1;
        }
        let before = if sector == 0 { 0.0 } else { self.areas[sector - 1] };
        let within = ((target - before) / (self.areas[sector] - before)).clamp(0.0, 1.0);
        let (a, b) = self.edge(sector);
        self.centre + v.sqrt() * a.lerp(b, within)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_polygon_fill_it_evenly() {
        let radii = (0..CORNERS).map(|i| 0.2 + 0.1 * direction(i).x).collect();
        let outline = Outline { centre: 0.3, radii };
        let polygon = Polygon::new(&outline, &outline).expect("an area");
        let n = 400;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
        let points: Vec<DVec2> = (0..n * n).map(|i| polygon.sample([at(i % n), at(i / n)])).collect();
        assert!(points.iter().all(|point| polygon.contains(*point)));
        // The share of any part is that of its area: the half plane right of the centre, by the shoelace formula.
        let right = points.iter().filter(|point| point.x > 0.0).count() as f64 / points.len() as f64;
        let quarter = CORNERS / 4;
        let of = |i: usize| 0.5 * polygon.edge(i).0.perp_dot(polygon.edge(i).1);
        let expected = (0..quarter).chain(3 * quarter..CORNERS).map(of).sum::<f64>() / polygon.area();
        assert!((right - expected).abs() < 2.0 / f64::from(n), "{right} {expected}");
    }
}
