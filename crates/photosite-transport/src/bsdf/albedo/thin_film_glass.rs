//! Change of albedo that a thin film makes to one bounce at a rough interface of two clear media.
//!
//! Of the power that meets a facet, R(c)·r + (1 − R(c))·t leaves after one bounce, with r and t what leaves if the
//! facet reflects or refracts all, and c the cosine to it outside. A film that changes R by ΔR, interpolated between
//! its values at the cosines cⱼ of [`FilmWeights`], changes the albedo by Σⱼ ΔR(cⱼ)·Wⱼ with Wⱼ that of r − t. Where
//! reflection is total it changes nothing. Anisotropic facets count by their mean roughness.

use std::sync::OnceLock;

use super::film::FilmWeights;
use super::glass::{ALPHAS, INDICES, MUS, index, position};
use super::grid::{Grid, GridRow, locate, mix};
use super::lattice::{LATTICE, from_cosine, lattice_mean};
use crate::bsdf::microfacet::Ggx;
use crate::bsdf::refraction::bounce;

/// Wⱼ for light at the cosine `mu`, above facets over an index of `eta`.
fn weights(eta: f32, distribution: Ggx, mu: f32) -> FilmWeights {
    let none = FilmWeights::hat(0.0) * 0.0;
    if distribution.is_smooth() {
        return none;
    }
    lattice_mean(0.5, LATTICE, |u| {
        let bounce = bounce(eta, distribution, from_cosine(mu), u);
        let cos_transmitted = bounce.interface.cos_transmitted;
        if cos_transmitted <= 0.0 {
            return none;
        }
        let outside = if eta > 1.0 { bounce.cos_o } else { cos_transmitted };
        FilmWeights::hat(outside) * (bounce.reflected - bounce.refracted)
    })
}

/// Film weights for light from either side, at one index and roughness.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct FilmGlassRow {
    /// Rows for light from the rarer side and from the denser one, each between two tabulated indices.
    rows: [[GridRow<FilmWeights>; 2]; 2],
    fraction: f32,
    far_is_rarer: bool,
}

impl FilmGlassRow {
    /// Returns the weights for the index `eta` of the far side over the near one.
    #[inline]
    pub(in crate::bsdf) fn of(eta: f32, distribution: Ggx) -> Self {
        let (i, fraction) = locate(position(eta), INDICES);
        let alpha = distribution.mean_alpha();
        let rows = table().each_ref().map(|side| [side[i].row(alpha), side[i + 1].row(alpha)]);
        Self { rows, fraction, far_is_rarer: eta < 1.0 }
    }

    /// Weights for light from the near side and from the far one, each at the cosine `mu` to the surface.
    #[inline]
    pub(in crate::bsdf) fn directional(&self, mu: f32) -> [FilmWeights; 2] {
        self.sides(|row| row.directional(mu))
    }

    /// Mean weights over the hemisphere, for light from the near side and from the far one.
    #[inline]
    pub(in crate::bsdf) fn mean(&self) -> [FilmWeights; 2] {
        self.sides(GridRow::mean)
    }

    #[inline]
    fn sides(&self, at: impl Fn(&GridRow<FilmWeights>) -> FilmWeights) -> [FilmWeights; 2] {
        let [rarer, denser] = self.rows.each_ref().map(|[below, above]| mix(at(below), at(above), self.fraction));
        if self.far_is_rarer { [denser, rarer] } else { [rarer, denser] }
    }
}

/// Tables by side and index.
pub(super) fn table() -> &'static [Vec<Grid<FilmWeights>>; 2] {
    static TABLE: OnceLock<[Vec<Grid<FilmWeights>>; 2]> = OnceLock::new();
    TABLE.get_or_init(|| {
        let grid = |eta: f32| Grid::new(ALPHAS, MUS, |alpha, mu| weights(eta, Ggx::new(alpha, alpha), mu));
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

    #[test]
    fn the_change_is_that_of_every_facet() {
        // Facets that reflect 0.2 more than Fresnel's equations say from each cosine, and those that reflect more the
        // flatter they are met: Σ over a fine lattice in place of the tables, whose error is that of their
        // interpolation.
        for eta in [1.33f32, 2.4, 1.0 / 1.5] {
            for alpha in [0.15f32, 0.6, 1.0] {
                let ggx = Ggx::new(alpha, alpha);
                for mu in [0.2f32, 0.5, 1.0] {
                    let row = FilmGlassRow::of(eta, ggx);
                    for (side, eta) in [eta, 1.0 / eta].into_iter().enumerate() {
                        for slope in [0.0f32, 0.3] {
                            let change = |cos: f32| 0.2 + slope * (1.0 - cos);
                            let found: f32 = (0..FILM_NODES)
                                .map(|j| change(node(j, FILM_NODES)) * row.directional(mu)[side].at(j))
                                .sum();
                            let fine = lattice_mean(0.5, (6765, 4181), |u| {
                                let bounce = bounce(eta, ggx, from_cosine(mu), u);
                                let cos = bounce.interface.cos_transmitted;
                                let outside = if eta > 1.0 { bounce.cos_o } else { cos };
                                if cos > 0.0 { change(outside) * (bounce.reflected - bounce.refracted) } else { 0.0 }
                            });
                            assert!((found - fine).abs() < 6e-3, "η {eta} α {alpha} μ {mu}: {found} is not {fine}");
                        }
                    }
                }
            }
        }
    }
}
