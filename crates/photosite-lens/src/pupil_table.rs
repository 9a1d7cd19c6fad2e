//! Directions from sensor points into the lens, drawn so that most of them pass.
//!
//! In direction cosines (p, q) the weight of a uniformly drawn direction is the area of the region that it is drawn from,
//! and nothing else (see [`illumination`](crate::illumination)). The table holds a polygon for each of many image heights
//! that contains the region S of all directions that pass, for all wavelengths, and little more.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;

use crate::lens::Lens;
use crate::region::outermost;

/// Image heights, from the axis to the corner, at which S is looked for.
const ROWS: usize = 65;
/// Corners of a polygon.
const CORNERS: usize = 64;
/// Directions for each corner in which the boundary is looked for.
const FINER: usize = 2;
/// Directions in which a region is looked for at first.
const FIRST_DIRECTIONS: usize = 16;
/// Bins of the image height, each with a polygon.
const BINS: usize = 512;
/// Halvings of the last stretch between a height that light reaches and one that it does not.
const HALVINGS: u32 = 6;
/// How much wider than found the polygons are. Between the directions and the heights of the table a smooth boundary
/// bulges by less; 1 % let 8e-4 of the light of some lenses leak out.
const MARGIN: f64 = 1.02;

/// What the sensor sees of the pupil, by image height.
#[derive(Clone, Debug)]
pub struct PupilTable {
    bins: Vec<Polygon>,
    bins_per_mm: f64,
    lit_mm: f64,
}

/// A direction that was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Direction cosines p, q; the ray goes out, towards −z.
    pub cosines: DVec2,
    /// Area of the region that it was drawn from, sr: the weight of what it brings, if it passes.
    pub area: f64,
}

/// A boundary at an image height on the y axis; centre on it, too, since a round stop leaves left and right alike.
#[derive(Clone, Debug)]
struct Row {
    centre: f64,
    radii: Vec<f64>,
}

/// Triangles about a centre.
#[derive(Clone, Debug)]
struct Polygon {
    centre: DVec2,
    /// From the centre.
    corners: Vec<DVec2>,
    /// Areas of the triangles up to and with each.
    areas: Vec<f64>,
    /// For each of as many equal parts of the whole area, the triangle in which it starts.
    starts: Vec<u8>,
    area: f64,
}

impl PupilTable {
    /// The table of a lens for image heights up to one in mm and wavelengths in nm, of which the middle one decides where
    /// the centres are. A stop with blades counts as round: what a blade cuts off is blocked when it is traced.
    pub fn new(lens: &Lens, highest_mm: f64, wavelengths_nm: &[f64]) -> Self {
        let lens = lens.with_round_stop();
        let height = |row: f64| highest_mm * row / (ROWS - 1) as f64;
        let mut rows: Vec<Option<Row>> = (0..ROWS).map(|i| Row::new(&lens, height(i as f64), wavelengths_nm)).collect();
        let lit_mm = image_circle(&lens, &rows, height, wavelengths_nm);
        // At heights that no light reaches, as at the last one that some does: in between the region shrinks.
        let mut last = None;
        for row in &mut rows {
            match row {
                Some(row) => last = Some(row.clone()),
                None => *row = last.take(),
            }
        }
        for i in 0..ROWS - 1 {
            let middle = Row::new(&lens, height(i as f64 + 0.5), wavelengths_nm);
            let [low, high] = &mut rows[i..=i + 1] else { continue };
            if let (Some(low), Some(high), Some(middle)) = (low, high, middle) {
                Row::widen_to(low, high, &middle);
            }
        }
        let at = |height: f64| {
            let row = height * (ROWS - 1) as f64;
            let i = (row as usize).min(ROWS - 2);
            Some(Row::between(rows[i].as_ref()?, rows[i + 1].as_ref()?, row - i as f64))
        };
        let of_bin = |bin: usize| {
            let [low, high] = [bin, bin + 1].map(|i| at(i as f64 / BINS as f64));
            Polygon::new(&low?, &high?)
        };
        let bins = (0..BINS).map(|bin| of_bin(bin).unwrap_or_else(Polygon::empty)).collect();
        Self { bins, bins_per_mm: BINS as f64 / highest_mm, lit_mm }
    }

    /// The largest image height that light reaches, mm, to a thousandth of the table's; that of the table where light
    /// reaches all of it.
    pub fn lit_mm(&self) -> f64 {
        self.lit_mm
    }

    /// Draws a direction for a sensor point, mm from the axis; `None` where no light reaches.
    pub fn sample(&self, point: DVec2, u: [f64; 2]) -> Option<Direction> {
        let polygon = self.polygon(point);
        let area = polygon.area();
        (area > 0.0).then(|| Direction { cosines: rotation(point).rotate(polygon.sample(u)), area })
    }

    /// Area of the region that directions are drawn from at a sensor point, sr; 0 where no light reaches.
    pub fn area(&self, point: DVec2) -> f64 {
        self.polygon(point).area()
    }

    /// Whether a direction is one that may be drawn at a sensor point.
    pub fn contains(&self, point: DVec2, cosines: DVec2) -> bool {
        let DVec2 { x, y } = rotation(point);
        self.polygon(point).contains(DVec2::new(x, -y).rotate(cosines))
    }

    fn polygon(&self, point: DVec2) -> &Polygon {
        &self.bins[((point.length() * self.bins_per_mm) as usize).min(BINS - 1)]
    }
}

/// The radius of the image circle: between the last row that light reaches and the next one, by halving.
fn image_circle(lens: &Lens, rows: &[Option<Row>], height: impl Fn(f64) -> f64, wavelengths_nm: &[f64]) -> f64 {
    let Some(last) = rows.iter().rposition(Option::is_some) else { return 0.0 };
    if last + 1 == rows.len() {
        return height(last as f64);
    }
    let middle = lens.at(wavelengths_nm[wavelengths_nm.len() / 2]);
    let (mut lit, mut dark) = (last as f64, last as f64 + 1.0);
    for _ in 0..HALVINGS {
        let half = 0.5 * (lit + dark);
        if middle.pupil_region(height(half), FIRST_DIRECTIONS).is_some() { lit = half } else { dark = half }
    }
    height(lit)
}

/// What turns the y axis to a point, as a complex number.
fn rotation(point: DVec2) -> DVec2 {
    let height = point.length();
    if height > 0.0 { DVec2::new(point.y, -point.x) / height } else { DVec2::X }
}

impl Row {
    /// The region of all wavelengths at an image height; `None` where no ray passes.
    fn new(lens: &Lens, height_mm: f64, wavelengths_nm: &[f64]) -> Option<Self> {
        let point = DVec2::new(0.0, height_mm);
        let middle = lens.at(wavelengths_nm[wavelengths_nm.len() / 2]);
        let region = middle.pupil_region(height_mm, FIRST_DIRECTIONS)?;
        let centre = DVec2::new(0.0, region.centre.y);
        let farthest = region.radii.iter().fold(0.0_f64, |most, radius| most.max(*radius));
        // What lies farther out between those directions, and at other wavelengths, is little.
        let circle = (centre, 1.5 * (farthest + region.centre.x.abs()));
        // From −y to +y: the other half is its mirror image.
        let half = FINER * CORNERS / 2;
        let mut fine = vec![0.0_f64; half + 1];
        for nm in wavelengths_nm {
            let at = lens.at(*nm);
            let passes = |cosines| at.passes(point, cosines);
            let mut guess = None;
            for (i, most) in fine.iter_mut().enumerate() {
                let angle = PI * i as f64 / half as f64 - FRAC_PI_2;
                let radius = outermost(&passes, centre, angle, guess, circle);
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
        Some(Self { centre: centre.y, radii: enclosing(&whole) })
    }

    /// Between two rows.
    fn between(low: &Self, high: &Self, t: f64) -> Self {
        let lerp = |a: f64, b: f64| a + t * (b - a);
        Self {
            centre: lerp(low.centre, high.centre),
            radii: low.radii.iter().zip(&high.radii).map(|(a, b)| lerp(*a, *b)).collect(),
        }
    }

    /// Widens two rows until what lies half way between them contains what was found there.
    fn widen_to(low: &mut Self, high: &mut Self, middle: &Self) {
        let between = Self::between(low, high, 0.5);
        let shift = DVec2::new(0.0, middle.centre - between.centre);
        let polygon = Polygon::of(&between);
        for (i, radius) in middle.radii.iter().enumerate() {
            let corner = shift + direction(i) * *radius;
            let sector = polygon.sector(corner);
            let factor = corner.length() / polygon.reach(sector, corner);
            for j in [sector, (sector + 1) % CORNERS] {
                if factor > 1.0 {
                    low.radii[j] *= factor;
                    high.radii[j] *= factor;
                }
            }
        }
    }
}

/// Direction of a corner from the centre.
fn direction(corner: usize) -> DVec2 {
    DVec2::from_angle(TAU * corner as f64 / CORNERS as f64)
}

/// Corners of a polygon that holds a boundary found in `FINER` directions for each.
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

/// How far it is to an edge from the origin in the direction of a point.
fn reach((a, b): (DVec2, DVec2), point: DVec2) -> f64 {
    let direction = point.normalize_or_zero();
    let along = b - a;
    let crossing = direction.perp_dot(along);
    if crossing == 0.0 { a.length() } else { a.perp_dot(along) / crossing }
}

impl Polygon {
    fn empty() -> Self {
        Self { centre: DVec2::ZERO, corners: Vec::new(), areas: Vec::new(), starts: Vec::new(), area: 0.0 }
    }

    fn of(row: &Row) -> Self {
        Self {
            centre: DVec2::new(0.0, row.centre),
            corners: row.radii.iter().enumerate().map(|(i, radius)| direction(i) * *radius).collect(),
            ..Self::empty()
        }
    }

    /// What contains two rows; `None` where they are empty.
    fn new(low: &Row, high: &Row) -> Option<Self> {
        let half = 0.5 * (high.centre - low.centre);
        let wider = |(a, b): (&f64, &f64)| a.max(*b) + half.abs();
        let radii: Vec<f64> = low.radii.iter().zip(&high.radii).map(wider).collect();
        let mut polygon = Self::of(&Row { centre: low.centre + half, radii });
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

    fn area(&self) -> f64 {
        self.area
    }

    fn edge(&self, sector: usize) -> (DVec2, DVec2) {
        (self.corners[sector], self.corners[(sector + 1) % CORNERS])
    }

    /// The triangle in whose angle a point from the centre lies.
    fn sector(&self, point: DVec2) -> usize {
        let turn = point.to_angle().rem_euclid(TAU) / TAU;
        ((turn * CORNERS as f64) as usize).min(CORNERS - 1)
    }

    fn reach(&self, sector: usize, point: DVec2) -> f64 {
        reach(self.edge(sector), point)
    }

    fn contains(&self, cosines: DVec2) -> bool {
        let point = cosines - self.centre;
        !self.areas.is_empty() && point.length() <= self.reach(self.sector(point), point)
    }

    /// A point of it, uniform over its area: a triangle by its area, then a point of the triangle.
    fn sample(&self, [u, v]: [f64; 2]) -> DVec2 {
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
        let row = Row { centre: 0.3, radii };
        let polygon = Polygon::new(&row, &row).expect("an area");
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

    #[test]
    fn directions_turn_with_the_point() {
        let turned = rotation(DVec2::new(-2.0, 0.0)).rotate(DVec2::Y);
        assert!(turned.distance(DVec2::NEG_X) < 1e-15, "{turned}");
        assert_eq!(rotation(DVec2::new(0.0, 3.0)).rotate(DVec2::Y), DVec2::Y);
    }
}
