//! A function of roughness and direction, tabulated and interpolated.
//!
//! Nodes are even in √α, the perceptual roughness, and in √μ, close together at grazing angles where albedos rise.
//! Between them everything is linear, and the mean 2∫f(μ)·μ dμ is the exact integral of the interpolated f: light that
//! is shared out by both adds up to what arrived.

use std::ops::{Add, Mul, Sub};

use glam::Vec2;

/// Value that can be interpolated linearly.
pub(in crate::bsdf) trait Value:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self>
{
}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>> Value for T {}

/// Values at all nodes.
pub(in crate::bsdf) struct Grid<T> {
    mus: usize,
    /// Row by row, one row for each roughness.
    directional: Vec<T>,
    mean: Vec<T>,
}

/// A grid at one roughness.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct GridRow<T: 'static> {
    below: &'static [T],
    above: &'static [T],
    mean: T,
    fraction: f32,
}

impl<T: Value> Grid<T> {
    /// Tabulates `f(α, μ)` at `alphas` × `mus` nodes.
    pub(super) fn new(alphas: usize, mus: usize, mut f: impl FnMut(f32, f32) -> T) -> Self {
        let square = |x: f32| x * x;
        let directional: Vec<T> =
            (0..alphas * mus).map(|i| f(square(node(i / mus, alphas)), square(node(i % mus, mus)))).collect();
        Self::from_values(mus, directional)
    }

    fn from_values(mus: usize, directional: Vec<T>) -> Self {
        let mean = directional.chunks_exact(mus).map(cosine_mean).collect();
        Self { mus, directional, mean }
    }

    /// Values of each roughness with their mean.
    pub(super) fn rows(&self) -> impl Iterator<Item = (&[T], T)> {
        self.directional.chunks_exact(self.mus).zip(self.mean.iter().copied())
    }

    /// Returns the row of the grid at the roughness `alpha`, interpolated.
    #[inline]
    pub(super) fn row(&'static self, alpha: f32) -> GridRow<T> {
        let (i, fraction) = locate(alpha.sqrt(), self.mean.len());
        let row = |i: usize| &self.directional[i * self.mus..(i + 1) * self.mus];
        GridRow { below: row(i), above: row(i + 1), mean: mix(self.mean[i], self.mean[i + 1], fraction), fraction }
    }
}

impl Grid<Vec2> {
    /// Tabulates what interpolation is not to lie below. `row(α, n)` gives the values at `n` even nodes of √μ; it is
    /// asked for nodes twice as close as the grid's, and where their values lie above a cell its corners are raised.
    pub(super) fn from_above(alphas: usize, mus: usize, row: impl Fn(f32, usize) -> Vec<Vec2>) -> Self {
        let (rows, columns) = (2 * alphas - 1, 2 * mus - 1);
        let fine: Vec<Vec<Vec2>> = (0..rows).map(|i| row(node(i, rows) * node(i, rows), columns)).collect();
        let exact = |i: usize, j: usize| fine[2 * i][2 * j];
        let mut raised: Vec<Vec2> = (0..alphas * mus).map(|k| exact(k / mus, k % mus)).collect();
        for (i, j) in (0..alphas - 1).flat_map(|i| (0..mus - 1).map(move |j| (i, j))) {
            let along = |i: usize, t: f32| mix(exact(i, j), exact(i, j + 1), t);
            let lacking = (0..9).fold(Vec2::ZERO, |lacking, k| {
                let (down, right) = (k / 3, k % 3);
                let t = 0.5 * right as f32;
                let found = mix(along(i, t), along(i + 1, t), 0.5 * down as f32);
                lacking.max(fine[2 * i + down][2 * j + right] - found)
            });
            for (i, j) in [(i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1)] {
                let corner = &mut raised[i * mus + j];
                *corner = corner.max(exact(i, j) + lacking);
            }
        }
        Self::from_values(mus, raised)
    }
}

impl<T: Value> GridRow<T> {
    /// Value for light from the direction of cosine `mu`.
    #[inline]
    pub(super) fn directional(&self, mu: f32) -> T {
        let (i, t) = locate(mu.sqrt(), self.below.len());
        let along = |row: &[T]| mix(row[i], row[i + 1], t);
        mix(along(self.below), along(self.above), self.fraction)
    }

    /// Mean value over the hemisphere, weighted by the cosine.
    #[inline]
    pub(super) fn mean(&self) -> T {
        self.mean
    }
}

#[inline]
pub(super) fn mix<T: Value>(a: T, b: T, t: f32) -> T {
    a + (b - a) * t
}

/// Place of `x` in 0–1 among `nodes` even nodes: the node below and the fraction of the way to the next.
#[inline]
pub(super) fn locate(x: f32, nodes: usize) -> (usize, f32) {
    let position = x.clamp(0.0, 1.0) * (nodes - 1) as f32;
    let node = (position as usize).min(nodes - 2);
    (node, position - node as f32)
}

/// The position of a node, 0–1.
pub(in crate::bsdf) fn node(i: usize, nodes: usize) -> f32 {
    i as f32 / (nodes - 1) as f32
}

/// 2∫f(μ)·μ dμ = 4∫f(t)·t³ dt, t = √μ, of the piecewise linear f given at even t.
pub(super) fn cosine_mean<T: Value>(values: &[T]) -> T {
    let mut mean = values[0] * 0.0;
    for i in 0..values.len() - 1 {
        let [a, b] = [i, i + 1].map(|i| i as f64 / (values.len() - 1) as f64);
        let (cubes, fourths) = (b.powi(4) - a.powi(4), 0.8 * (b.powi(5) - a.powi(5)));
        // ∫4t³·(b − t)/(b − a) dt and ∫4t³·(t − a)/(b − a) dt.
        let (low, high) = ((b * cubes - fourths) / (b - a), (fourths - a * cubes) / (b - a));
        mean = mean + values[i] * low as f32 + values[i + 1] * high as f32;
    }
    mean
}
