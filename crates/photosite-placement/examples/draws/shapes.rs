//! Shapes to place: convex and concave, round and flat.

use std::f64::consts::TAU;

use glam::DVec3;
use photosite_placement::cuboid;

/// Positions in metres, and triangles.
pub(crate) type Mesh = (Vec<DVec3>, Vec<[u32; 3]>);

/// All shapes, by name.
pub(crate) fn all() -> Vec<(&'static str, Mesh)> {
    vec![
        ("box", cuboid(DVec3::new(-0.03, -0.01, -0.02), DVec3::new(0.03, 0.02, 0.04))),
        ("angle", angle(0.03)),
        ("torus", torus(0.05, 0.02)),
        ("bowl", bowl(0.06)),
        ("can", can(0.03, 0.09)),
        ("stone", stone(0.045)),
        ("card", card(0.08, 0.05)),
    ]
}

/// An L, extruded.
pub(crate) fn angle(s: f64) -> Mesh {
    let outline = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)];
    let positions = [0.0, 1.0].iter().flat_map(|z| outline.map(|(x, y)| DVec3::new(x, y, *z) * s)).collect();
    let mut triangles = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.extend([[a, c, b], [a + 6, b + 6, c + 6]]);
    }
    for i in 0..6 {
        let j = (i + 1) % 6;
        triangles.extend([[i, j, j + 6], [i, j + 6, i + 6]]);
    }
    (positions, triangles)
}

/// A ring.
pub(crate) fn torus(ring: f64, tube: f64) -> Mesh {
    revolved(32, &circle(16, |v| (ring + tube * v.cos(), tube * v.sin())))
}

/// A bowl with a wall as thick as a seventh of it.
pub(crate) fn bowl(r: f64) -> Mesh {
    let arc = |r: f64| move |k: u32| (1.5 * f64::from(k) / 12.0, r);
    let at = |(angle, own): (f64, f64)| (0.02 * r + own * angle.sin(), r - own * angle.cos());
    let outside = (0..=12).map(arc(r)).map(at);
    let inside = (0..=12).rev().map(arc(0.85 * r)).map(at);
    let profile: Vec<(f64, f64)> = outside.chain(inside).collect();
    revolved(32, &profile)
}

/// A cylinder, closed.
pub(crate) fn can(r: f64, height: f64) -> Mesh {
    let n = 32;
    let mut positions: Vec<DVec3> = Vec::new();
    for y in [0.0, height] {
        positions.extend((0..n).map(|i| {
            let angle = TAU * f64::from(i) / f64::from(n);
            DVec3::new(r * angle.cos(), y, r * angle.sin())
        }));
    }
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[i, j + n, j], [i, i + n, j + n]]);
        if i > 0 && j > 0 {
            triangles.extend([[0, i, j], [n, j + n, i + n]]);
        }
    }
    (positions, triangles)
}

/// A lump with dents, like a scanned stone.
pub(crate) fn stone(r: f64) -> Mesh {
    let (rows, columns) = (16u32, 24u32);
    let place = |theta: f64, phi: f64| {
        let dents = 1.0 + 0.18 * (3.0 * phi).cos() * theta.sin().powi(3) + 0.1 * (5.0 * theta).cos();
        let direction = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
        direction * r * dents * DVec3::new(1.0, 0.7, 1.2)
    };
    let mut positions = vec![place(0.0, 0.0), place(TAU / 2.0, 0.0)];
    for row in 1..rows {
        let theta = TAU / 2.0 * f64::from(row) / f64::from(rows);
        positions.extend((0..columns).map(|column| place(theta, TAU * f64::from(column) / f64::from(columns))));
    }
    let number = |row: u32, column: u32| 2 + (row - 1) * columns + column % columns;
    let mut triangles = Vec::new();
    for c in 0..columns {
        triangles.push([0, number(1, c + 1), number(1, c)]);
        triangles.push([1, number(rows - 1, c), number(rows - 1, c + 1)]);
        for row in 1..rows - 1 {
            let [a, b, d, e] = [number(row, c), number(row, c + 1), number(row + 1, c), number(row + 1, c + 1)];
            triangles.extend([[a, b, e], [a, e, d]]);
        }
    }
    (positions, triangles)
}

/// A sheet without thickness.
pub(crate) fn card(width: f64, depth: f64) -> Mesh {
    let positions = [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)].map(|(x, z)| DVec3::new(x, 0.0, z));
    (positions.to_vec(), vec![[0, 2, 1], [0, 3, 2]])
}

fn circle(n: u32, at: impl Fn(f64) -> (f64, f64)) -> Vec<(f64, f64)> {
    (0..n).map(|i| at(TAU * f64::from(i) / f64::from(n))).collect()
}

/// A closed profile of radii and heights, turning left, about the vertical.
fn revolved(n: u32, profile: &[(f64, f64)]) -> Mesh {
    let m = profile.len() as u32;
    let mut positions = Vec::new();
    for i in 0..n {
        let angle = TAU * f64::from(i) / f64::from(n);
        positions.extend(profile.iter().map(|&(r, y)| DVec3::new(r * angle.cos(), y, r * angle.sin())));
    }
    let number = |i: u32, j: u32| (i % n) * m + j % m;
    let quads = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let triangles = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [number(i, j), number(i, j + 1), number(i + 1, j + 1), number(i + 1, j)];
        [[a, b, c], [a, c, d]]
    });
    (positions, triangles.collect())
}
