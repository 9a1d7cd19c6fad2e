//! All slanted edges of an image, found by themselves.
//!
//! Pixels where the image changes strongly, in one of four directions (to the right, the left, up and down, at most 45°
//! off), form groups of neighbours. A group is an edge where it is long, its middle is straight, and it is a few degrees off
//! the pixels' columns or rows. Its region leaves out the ends, where edges meet, and is as wide as it can be without any
//! other strong change.

use super::mtf::{EdgeResponse, slanted_edge};

/// Pixels to each side over which changes are measured, so that noise of single pixels is small beside them.
const REACH: usize = 2;
/// Part of the strongest change above which one is strong.
const STRONG: f64 = 0.25;
/// Changes by noise alone, in its standard deviations, below which none is strong.
const SIGMAS: f64 = 6.0;
/// Least length of an edge, px.
const LEAST_LENGTH: usize = 24;
/// Largest deviation of its middle from a straight line, root of the mean square, px.
const STRAIGHT_PX: f64 = 0.5;
/// Slopes of edges: 1° to 40° off the pixels.
const SLOPES: std::ops::RangeInclusive<f64> = 0.0175..=0.84;
/// Parts of the length that are left out at each end, and widths to each side, px, the best first.
const ENDS: [f64; 3] = [0.08, 0.15, 0.25];
const SIDES: [usize; 5] = [24, 20, 16, 12, 8];

/// An edge: its region (column, row, columns, rows), and its response.
pub type FoundEdge = ([usize; 4], EdgeResponse);

/// The slanted edges of a plane of linear values, row by row from the top.
pub fn slanted_edges(plane: &[f32], size: [usize; 2]) -> Vec<FoundEdge> {
    let changes = Changes::new(plane, size);
    let mut edges: Vec<FoundEdge> = changes
        .groups()
        .iter()
        .filter_map(|group| {
            let regions = group.regions(size)?;
            let alone = |region: &[usize; 4]| changes.are_of(group.number, *region);
            let measured = |region: [usize; 4]| Some((region, slanted_edge(plane, size, region).ok()?));
            regions.into_iter().filter(alone).find_map(measured)
        })
        .collect();
    edges.sort_by_key(|([left, top, ..], _)| [*top, *left]);
    edges
}

/// Strong changes of an image from pixel to pixel.
struct Changes {
    size: [usize; 2],
    /// Strengths of the changes.
    strength: Vec<f64>,
    /// The direction of strong ones, 1 to 4 as [`direction`] has it; 0 elsewhere.
    direction: Vec<u8>,
    /// Index of the group that each pixel belongs to; 0 for none.
    group: Vec<u32>,
    /// Pixels of each group.
    members: Vec<Vec<usize>>,
}

/// Right, left, down, up.
fn direction([across, down]: [f64; 2]) -> u8 {
    match (across.abs() >= down.abs(), across > 0.0, down > 0.0) {
        (true, true, _) => 1,
        (true, false, _) => 2,
        (false, _, true) => 3,
        (false, _, false) => 4,
    }
}

impl Changes {
    fn new(plane: &[f32], size: [usize; 2]) -> Self {
        let [width, height] = size;
        let mut vectors = vec![[0.0; 2]; width * height];
        let side = REACH as isize;
        for y in REACH..height.saturating_sub(REACH) {
            for x in REACH..width.saturating_sub(REACH) {
                let mut sum = [0.0; 2];
                for dy in -side..=side {
                    for dx in -side..=side {
                        let value = f64::from(plane[y.wrapping_add_signed(dy) * width + x.wrapping_add_signed(dx)]);
                        sum[0] += dx.signum() as f64 * value;
                        sum[1] += dy.signum() as f64 * value;
                    }
                }
                vectors[y * width + x] = sum;
            }
        }
        let strength: Vec<f64> = vectors.iter().map(|[x, y]| x.hypot(*y)).collect();
        let mut sorted: Vec<f64> = strength.iter().copied().filter(|s| s.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        // Most pixels lie on no edge. Strengths of noise are Rayleigh-distributed, whose median is σ·√(2 ln 2).
        let noise = sorted.get(sorted.len() / 2).map_or(0.0, |median| median / (2.0 * 2f64.ln()).sqrt());
        let threshold = (STRONG * sorted.last().copied().unwrap_or(0.0)).max(SIGMAS * noise);
        let strong = |(s, vector): (&f64, &[f64; 2])| if *s > threshold { direction(*vector) } else { 0 };
        let direction: Vec<u8> = strength.iter().zip(&vectors).map(strong).collect();
        let mut changes = Self { size, strength, direction, group: vec![0; width * height], members: Vec::new() };
        changes.gather();
        changes
    }

    /// Puts neighbours of one direction into groups.
    fn gather(&mut self) {
        let [width, height] = self.size;
        for start in 0..width * height {
            if self.direction[start] == 0 || self.group[start] > 0 {
                continue;
            }
            let number = self.members.len() as u32 + 1;
            self.group[start] = number;
            let (mut members, mut next) = (vec![start], 0);
            while let Some(&at) = members.get(next) {
                next += 1;
                let (x, y) = (at % width, at / width);
                for ny in y.saturating_sub(1)..(y + 2).min(height) {
                    for nx in x.saturating_sub(1)..(x + 2).min(width) {
                        let neighbour = ny * width + nx;
                        if self.group[neighbour] == 0 && self.direction[neighbour] == self.direction[start] {
                            self.group[neighbour] = number;
                            members.push(neighbour);
                        }
                    }
                }
            }
            self.members.push(members);
        }
    }

    fn groups(&self) -> Vec<Group> {
        let group = |(i, members): (usize, &Vec<usize>)| {
            let is_vertical = self.direction[members[0]] <= 2;
            Group::new(i as u32 + 1, is_vertical, members, &self.strength, self.size[0])
        };
        self.members.iter().enumerate().filter_map(group).collect()
    }

    /// Whether all strong changes of a region are those of a group.
    fn are_of(&self, number: u32, [left, top, columns, rows]: [usize; 4]) -> bool {
        let row = |y: usize| &self.group[y * self.size[0] + left..][..columns];
        (top..top + rows).all(|y| row(y).iter().all(|group| [0, number].contains(group)))
    }
}

/// An edge that is straight. Lines run across it: rows, if it is vertical, else columns.
struct Group {
    number: u32,
    is_vertical: bool,
    /// Range of lines that the edge crosses.
    lines: [usize; 2],
    /// Place of the edge in line 0, pixels; `slope` is its change from line to line.
    offset: f64,
    slope: f64,
}

impl Group {
    fn new(number: u32, is_vertical: bool, members: &[usize], strength: &[f64], width: usize) -> Option<Self> {
        let split = |at: usize| if is_vertical { (at / width, at % width) } else { (at % width, at / width) };
        let first = members.iter().map(|&at| split(at).0).min()?;
        let last = members.iter().map(|&at| split(at).0).max()?;
        let length = last - first + 1;
        if length < LEAST_LENGTH {
            return None;
        }
        let mut sums = vec![(0.0, 0.0); length];
        for &at in members {
            let (line, x) = split(at);
            let (weights, sum) = &mut sums[line - first];
            *weights += strength[at];
            *sum += strength[at] * x as f64;
        }
        // At its ends other edges pull at it.
        let cut = length / 10;
        let middle: Vec<(f64, f64)> =
            (cut..length - cut).map(|i| ((first + i) as f64, sums[i].1 / sums[i].0)).collect();
        if middle.iter().any(|(_, x)| !x.is_finite()) {
            return None;
        }
        let n = middle.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| middle.iter().map(of).sum::<f64>() / n;
        let (mean_line, mean_x) = (mean(|m| m.0), mean(|m| m.1));
        let covariance: f64 = middle.iter().map(|(line, x)| (line - mean_line) * (x - mean_x)).sum();
        let slope = covariance / middle.iter().map(|(line, _)| (line - mean_line).powi(2)).sum::<f64>();
        let offset = mean_x - slope * mean_line;
        let square = middle.iter().map(|(line, x)| (x - offset - slope * line).powi(2)).sum::<f64>() / n;
        let is_edge = square.sqrt() < STRAIGHT_PX && SLOPES.contains(&slope.abs());
        is_edge.then_some(Self { number, is_vertical, lines: [first, last], offset, slope })
    }

    /// Regions around it within an image, the best first.
    fn regions(&self, [width, height]: [usize; 2]) -> Option<Vec<[usize; 4]>> {
        let across = if self.is_vertical { width } else { height };
        let length = self.lines[1] - self.lines[0] + 1;
        let mut regions = Vec::new();
        for side in SIDES {
            for end in ENDS {
                let cut = (end * length as f64).ceil() as usize;
                let (first, last) = (self.lines[0] + cut, (self.lines[1] + 1).checked_sub(cut)?);
                let ends = [first, last].map(|line| self.offset + self.slope * line as f64);
                let left = ends[0].min(ends[1]) - side as f64;
                let right = ends[0].max(ends[1]) + side as f64 + 1.0;
                if left < 0.0 || right > across as f64 || last < first + 16 {
                    continue;
                }
                let (left, columns) = (left as usize, right as usize - left as usize);
                regions.push(match self.is_vertical {
                    true => [left, first, columns, last - first],
                    false => [first, left, last - first, columns],
                });
            }
        }
        Some(regions)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_images::{Even, normal, truth};
    use super::*;

    const SIZE: [usize; 2] = [240, 200];
    const SIGMA: f64 = 0.6;

    /// Dark squares on grey, turned by an angle, blurred by a Gaussian, averaged over each pixel's area by 8 × 8 points:
    /// far from corners each edge is that of a half plane.
    fn squares(places: &[[f64; 3]], angle_deg: f64, noise: f64) -> Vec<f32> {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let mut random = Even(1);
        let value = |i: usize| {
            let mut sum = 0.0;
            for k in 0..64 {
                let (dx, dy) = ((f64::from(k % 8) + 0.5) / 8.0 - 0.5, (f64::from(k / 8) + 0.5) / 8.0 - 0.5);
                let (x, y) = ((i % SIZE[0]) as f64 + dx, (i / SIZE[0]) as f64 + dy);
                for [cx, cy, half] in places {
                    let (u, v) = ((x - cx) * cos + (y - cy) * sin, (y - cy) * cos - (x - cx) * sin);
                    let inside = |t: f64| normal((half - t) / SIGMA) - normal((-half - t) / SIGMA);
                    sum += inside(u) * inside(v) / 64.0;
                }
            }
            (0.8 - 0.7 * sum + noise * random.next()) as f32
        };
        (0..SIZE[0] * SIZE[1]).map(value).collect()
    }

    #[test]
    fn every_edge_of_turned_squares_is_found_and_has_its_transfer_function() {
        let places = [[62.0, 60.0, 35.0], [175.0, 60.0, 30.0], [120.0, 150.0, 32.0]];
        for (angle, noise) in [(5.0, 0.0), (-8.0, 0.0), (6.0, 0.01)] {
            let edges = slanted_edges(&squares(&places, angle, noise), SIZE);
            assert_eq!(
                edges.len(),
                4 * places.len(),
                "{angle}°: {:?}",
                edges.iter().map(|(r, _)| r).collect::<Vec<_>>()
            );
            assert_eq!(edges.iter().filter(|(_, edge)| edge.is_vertical).count(), 2 * places.len());
            for (region, edge) in &edges {
                assert!((edge.angle_deg.abs() - f64::abs(angle)).abs() < 0.2, "{region:?}: {}°", edge.angle_deg);
                for (f, m) in [(10, edge.mtf[10]), (25, edge.mtf[25]), (40, edge.mtf[40])] {
                    let expected = truth(f64::from(f) / 100.0, angle, SIGMA);
                    // As in the tests of one edge, whose 96 rows are half as many again as these.
                    let bound = 0.02 + 4.0 * edge.standard_error[f as usize];
                    assert!((m - expected).abs() < bound, "{region:?}: {m} at {f} %, must be {expected}");
                }
            }
        }
    }

    #[test]
    fn images_without_a_slanted_edge_have_none() {
        for plane in [vec![0.5; SIZE[0] * SIZE[1]], squares(&[], 0.0, 0.1), squares(&[[120.0, 100.0, 50.0]], 0.0, 0.0)]
        {
            assert!(slanted_edges(&plane, SIZE).is_empty());
        }
        assert!(slanted_edges(&[], [0, 0]).is_empty());
        assert!(slanted_edges(&[0.0, 1.0, 0.0, 1.0], [2, 2]).is_empty());
    }
}
