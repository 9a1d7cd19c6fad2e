//! Convex hulls, also of flat shapes.

use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;
use photosite_core::Invalid;

/// Half the thickness of flat shapes where a volume is needed, m: a tenth of the precision of placement.
pub(crate) const HALF_SHEET_M: f64 = 5e-6;

/// A convex solid.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    pub(crate) points: Vec<Vector>,
    /// Triangles, counter-clockwise as seen from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Hull {
    /// Hull of the points of some triangles; for flat ones, a thin foil around them.
    pub(crate) fn around(points: &[Vector], triangles: &[[u32; 3]]) -> Result<Self, Invalid> {
        Self::of(points).or_else(|| Self::foil(points, triangles)).ok_or_else(|| {
            Invalid::new("", "the mesh has no convex hull").help("it must extend in at least two directions")
        })
    }

    /// Hull of some points; `None` where they have none.
    pub(crate) fn of(points: &[Vector]) -> Option<Self> {
        let (points, triangles) = try_convex_hull(points).ok()?;
        let is_solid = volume(&points, &triangles) > 0.0;
        is_solid.then_some(Self { points, triangles })
    }

    /// Outline of flat triangles, made as thick as a foil.
    fn foil(points: &[Vector], triangles: &[[u32; 3]]) -> Option<Self> {
        let area_vector = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| points[i as usize]);
            (b - a).cross(c - a)
        };
        let larger = |a: Vector, b: Vector| if b.length_squared() > a.length_squared() { b } else { a };
        let up = triangles.iter().map(area_vector).fold(Vector::ZERO, larger).try_normalize()?;
        let heights = || points.iter().map(|p| p.dot(up));
        let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
        let right = up.any_orthonormal_vector();
        let forward = up.cross(right);
        let outline = outline(points.iter().map(|p| [p.dot(right), p.dot(forward)]).collect());
        let n = outline.len() as u32;
        if n < 3 {
            return None;
        }
        let at = |height: f64| move |&[x, y]: &[f64; 2]| right * x + forward * y + up * height;
        let bottom = outline.iter().map(at(low - HALF_SHEET_M));
        let points = bottom.chain(outline.iter().map(at(high + HALF_SHEET_M))).collect();
        let caps = (2..n).flat_map(|i| [[0, i, i - 1], [n, n + i - 1, n + i]]);
        let sides = (0..n).map(|i| (i, (i + 1) % n)).flat_map(|(i, j)| [[i, j, j + n], [i, j + n, i + n]]);
        Some(Self { points, triangles: caps.chain(sides).collect() })
    }
}

/// Convex outline of points of a plane, counter-clockwise (Andrew's monotone chain).
fn outline(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let turn =
        |[ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]| (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && turn(a, b, point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let lower = half(&mut points.iter().copied());
    let upper = half(&mut points.iter().rev().copied());
    [lower, upper].concat()
}

/// Volume enclosed by triangles, below 0 where they are inside out.
pub(crate) fn volume(points: &[Vector], triangles: &[[u32; 3]]) -> f64 {
    let origin = points.first().copied().unwrap_or_default();
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| points[i as usize] - origin);
        a.dot(b.cross(c)) / 6.0
    };
    triangles.iter().map(of).sum()
}
