//! The directional albedo of a GGX lobe whose Fresnel factor is that of a thin film.

use std::sync::OnceLock;

use glam::Vec4;

use super::grid::{Grid, GridRow, locate};
use super::lattice::{from_cosine, integrate};
use super::reflection::NODES;
use crate::bsdf::microfacet::Ggx;

/// Number of cosines at which the reflectance of a film is sampled, even from 0 to 1.
pub(in crate::bsdf) const FILM_NODES: usize = 8;

/// Weights Wⱼ of the reflectances at the cosines j/7.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct FilmWeights([Vec4; 2]);

impl std::ops::Add for FilmWeights {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl std::ops::Sub for FilmWeights {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
}

impl std::ops::Mul<f32> for FilmWeights {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self([self.0[0] * factor, self.0[1] * factor])
    }
}

impl FilmWeights {
    /// Piecewise linear interpolation at `cos`.
    #[inline]
    pub(in crate::bsdf) fn hat(cos: f32) -> Self {
        let (i, t) = locate(cos, FILM_NODES);
        let weight = |j: usize| if j == i { 1.0 - t } else { f32::from(u8::from(j == i + 1)) * t };
        Self([0, 4].map(|j| Vec4::new(weight(j), weight(j + 1), weight(j + 2), weight(j + 3))))
    }

    /// Weights of the mean over the hemisphere, ∫2μ·R(μ) dμ.
    #[inline]
    pub(in crate::bsdf) fn cosine_mean() -> Self {
        // Of a hat of half width h about c: 2c·h; half a hat about 0 and about 1: h²/3 and h − h²/3.
        let h = 1.0 / (FILM_NODES - 1) as f32;
        let weight = |j: usize| match j {
            0 => h * h / 3.0,
            _ if j == FILM_NODES - 1 => h - h * h / 3.0,
            _ => 2.0 * h * (h * j as f32),
        };
        Self([0, 4].map(|j| Vec4::new(weight(j), weight(j + 1), weight(j + 2), weight(j + 3))))
    }

    /// Sum of the weights.
    #[inline]
    pub(in crate::bsdf) fn sum(&self) -> f32 {
        (self.0[0] + self.0[1]).element_sum()
    }

    /// Weight of node `j`.
    #[inline]
    pub(in crate::bsdf) fn at(&self, j: usize) -> f32 {
        self.0[j / 4][j % 4]
    }
}

/// Nodes along √α.
pub(super) const ALPHAS: usize = 16;

/// Weights by roughness and cosine.
pub(super) fn table() -> &'static Grid<FilmWeights> {
    static TABLE: OnceLock<Grid<FilmWeights>> = OnceLock::new();
    TABLE.get_or_init(|| {
        Grid::new(ALPHAS, NODES, |alpha, mu| {
            if alpha == 0.0 {
                return FilmWeights::hat(mu);
            }
            integrate(Ggx::new(alpha, alpha), from_cosine(mu), |_, cos_facet| FilmWeights::hat(cos_facet))
        })
    })
}

/// The weights for a GGX lobe of one roughness, directional and mean.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct FilmRow(GridRow<FilmWeights>);

impl FilmRow {
    #[inline]
    pub(in crate::bsdf) fn of(distribution: Ggx) -> Self {
        Self(table().row(distribution.mean_alpha()))
    }

    #[inline]
    pub(in crate::bsdf) fn directional(&self, mu: f32) -> FilmWeights {
        self.0.directional(mu)
    }

    #[inline]
    pub(in crate::bsdf) fn mean(&self) -> FilmWeights {
        self.0.mean()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::albedo::Row;
    use crate::bsdf::albedo::grid::node;

    #[test]
    fn film_weights_know_the_constant_and_the_identity() {
        // Σ Wⱼ is the albedo of a white lobe; Σ cⱼ·Wⱼ on a polished surface is the cosine itself.
        for alpha in [0.0, 0.3, 1.0] {
            let ggx = Ggx::new(alpha, alpha);
            for mu in [0.2, 0.6, 1.0] {
                let weights = FilmRow::of(ggx).directional(mu);
                let sum = weights.sum();
                let white = Row::of(ggx).directional(from_cosine(mu)).at(1.0);
                // Two tables of different steps in α: 1e-3.
                assert!((sum - white).abs() < 2e-3, "α {alpha} μ {mu}: {sum} is not {white}");
            }
        }
        let mirror = FilmRow::of(Ggx::SMOOTH).directional(0.7);
        let cos: f32 = (0..FILM_NODES).map(|j| mirror.at(j) * node(j, FILM_NODES)).sum();
        assert!((cos - 0.7).abs() < 1e-3, "{cos}");
    }
}
