//! What one bounce at a rough interface of two clear media with a film on it reflects and refracts together.
//!
//! Of the power that meets a facet, R(c)·r + (1 − R(c))·t leaves after one bounce, with r and t what leaves if the facet
//! reflects or refracts all, and c the cosine to it outside. With R interpolated between its values at the cosines cⱼ of
//! [`FilmWeights`] the albedo is V + Σⱼ R(cⱼ)·Wⱼ; facets of total reflection count in V. Anisotropic facets count by
//! their mean roughness.

use std::ops::{Add, Mul, Sub};
use std::sync::OnceLock;

use super::glass::{ALPHAS, INDICES, MUS, index, place};
use super::grid::{Grid, GridRow, locate, mix};
use super::{FilmWeights, LATTICE, from_cosine, lattice_mean};
use crate::bsdf::dielectric;
use crate::bsdf::microfacet::Ggx;

/// V and Wⱼ.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct FilmGlass {
    /// V.
    pub(in crate::bsdf) rest: f32,
    /// Wⱼ.
    pub(in crate::bsdf) weights: FilmWeights,
}

impl FilmGlass {
    /// Light from `wo`, above facets over an index of `eta`.
    fn new(eta: f32, distribution: Ggx, mu: f32) -> Self {
        if distribution.is_smooth() {
            return Self { rest: 1.0, weights: FilmWeights::hat(0.0) * 0.0 };
        }
        lattice_mean(0.5, LATTICE, |u| {
            let bounce = dielectric::bounce(eta, distribution, from_cosine(mu), u);
            let cos_transmitted = bounce.interface.cos_transmitted;
            if cos_transmitted <= 0.0 {
                return Self { rest: bounce.reflected, weights: FilmWeights::hat(0.0) * 0.0 };
            }
            let outside = if eta > 1.0 { bounce.cos_o } else { cos_transmitted };
            let weights = FilmWeights::hat(outside) * (bounce.reflected - bounce.refracted);
            Self { rest: bounce.refracted, weights }
        })
    }
}

impl Add for FilmGlass {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { rest: self.rest + other.rest, weights: self.weights + other.weights }
    }
}

impl Sub for FilmGlass {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { rest: self.rest - other.rest, weights: self.weights - other.weights }
    }
}

impl Mul<f32> for FilmGlass {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self { rest: self.rest * factor, weights: self.weights * factor }
    }
}

/// The same for light from either side, at one index and roughness.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct FilmGlassRow {
    /// From the rarer side and from the denser one, each between two tabulated indices.
    rows: [[GridRow<FilmGlass>; 2]; 2],
    fraction: f32,
    far_is_rarer: bool,
}

impl FilmGlassRow {
    /// For the index `eta` of the far side over the near one.
    #[inline]
    pub(in crate::bsdf) fn of(eta: f32, distribution: Ggx) -> Self {
        let (i, fraction) = locate(place(eta), INDICES);
        let alpha = distribution.mean_alpha();
        let rows = table().each_ref().map(|side| [side[i].row(alpha), side[i + 1].row(alpha)]);
        Self { rows, fraction, far_is_rarer: eta < 1.0 }
    }

    /// From the near side and from the far one, each at the cosine `mu` to the surface.
    #[inline]
    pub(in crate::bsdf) fn directional(&self, mu: f32) -> [FilmGlass; 2] {
        self.sides(|row| row.directional(mu))
    }

    /// For light from everywhere.
    #[inline]
    pub(in crate::bsdf) fn mean(&self) -> [FilmGlass; 2] {
        self.sides(GridRow::mean)
    }

    #[inline]
    fn sides(&self, at: impl Fn(&GridRow<FilmGlass>) -> FilmGlass) -> [FilmGlass; 2] {
        let [rarer, denser] = self.rows.each_ref().map(|[below, above]| mix(at(below), at(above), self.fraction));
        if self.far_is_rarer { [denser, rarer] } else { [rarer, denser] }
    }
}

/// By side and index.
fn table() -> &'static [Vec<Grid<FilmGlass>>; 2] {
    static TABLE: OnceLock<[Vec<Grid<FilmGlass>>; 2]> = OnceLock::new();
    TABLE.get_or_init(|| {
        let grid = |eta: f32| Grid::new(ALPHAS, MUS, |alpha, mu| FilmGlass::new(eta, Ggx::new(alpha, alpha), mu));
        [false, true].map(|from_denser| {
            let eta = |i| if from_denser { 1.0 / index(i, INDICES) } else { index(i, INDICES) };
            (0..INDICES).map(|i| grid(eta(i))).collect()
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::{FILM_NODES, node};
    use super::*;
    use crate::bsdf::albedo::GlassRow;
    use crate::bsdf::fresnel;

    #[test]
    fn without_a_film_the_albedo_is_that_of_glass() {
        // Fresnel's reflectance at the nodes in place of a film's: the tables differ by its interpolation between cosines of
        // 1/7, at 0 where it falls from 1 with slope 5 or so: 5/7/8 of the little that is seen there.
        for eta in [1.33f32, 1.5, 2.4, 1.0 / 1.5] {
            for alpha in [0.15f32, 0.6, 1.0] {
                let ggx = Ggx::new(alpha, alpha);
                for mu in [0.2f32, 0.5, 1.0] {
                    let film = FilmGlassRow::of(eta, ggx).directional(mu);
                    let glass = GlassRow::of(eta, ggx).directional(from_cosine(mu));
                    for (side, (film, glass)) in film.into_iter().zip(glass).enumerate() {
                        let outside = eta.max(1.0 / eta);
                        let reflectance = |j| fresnel::dielectric(node(j, FILM_NODES), outside).reflectance;
                        let sum: f32 = (0..FILM_NODES).map(|j| reflectance(j) * film.weights.at(j)).sum();
                        let error = film.rest + sum - glass;
                        assert!(error.abs() < 0.01, "η {eta} α {alpha} μ {mu} side {side}: {error}");
                    }
                }
            }
        }
    }
}
