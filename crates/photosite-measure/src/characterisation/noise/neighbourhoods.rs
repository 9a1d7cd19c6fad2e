//! Noise of a single image: of many small neighbourhoods, each with a plane of its own.

use serde::Serialize;

use super::patch::{Patch, Variance};
use super::plane_fit::{ChiSquared, PlaneFit};
use super::sigma_distribution::SigmaDistribution;

/// Noise that planes leave in squares of pixels side by side, in every image by itself. Shading that bends over the
/// image is nearly a plane in each; edges are not, and show as a tail of large σ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Neighbourhoods {
    /// Pixels along a side of a square, s.
    pub side: usize,
    /// Mean variance, with all degrees of freedom, s² − 3 of each.
    pub noise: Variance,
    /// Distribution of the squares' standard deviations.
    pub sigmas: SigmaDistribution,
    /// Whether noise of the known variance explains what all planes together leave.
    pub chi_squared: Option<ChiSquared>,
}

impl Neighbourhoods {
    /// Fits a plane to each square of `side` × `side` pixels; pixels that are left at the right and at the bottom do
    /// not count. `None` where there is not one square.
    pub(super) fn new(patches: &[Patch], side: usize, known_variance: Option<f64>) -> Option<Self> {
        let squares = patches.iter().flat_map(|patch| patch.squares(side));
        let fits: Vec<Variance> = squares.map(|square| PlaneFit::new(&square, None).0.noise).collect();
        if fits.is_empty() {
            return None;
        }
        let freedom = (side * side - 3) as f64;
        let total = freedom * fits.iter().map(|noise| noise.variance).sum::<f64>();
        let all = freedom * fits.len() as f64;
        let noise = Variance::of(total, all);
        let known = known_variance.filter(|&variance| variance > 0.0);
        let sigma = known.map_or(noise.sigma, f64::sqrt);
        Some(Self {
            side,
            noise,
            sigmas: SigmaDistribution::new(fits.iter().map(|noise| noise.sigma).collect(), freedom, sigma),
            chi_squared: known.map(|variance| ChiSquared::new(total / variance, all)),
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use super::*;
    use photosite_core::math::philox::Philox;

    #[test]
    fn bent_shading_is_a_plane_in_each_square() {
        let (width, height, sigma) = (210, 140, 2.0);
        let value = |i: usize| {
            let [x, y] = [i % width, i / width].map(|n| n as f64);
            // Bends by less than 0.002·3.5²/2 within a square of 7 pixels.
            300.0
                + 0.001 * (x - 100.0).powi(2)
                + 0.5 * y
                + sigma * Philox::new(5, i as u64).sample::<f64, _>(StandardNormal)
        };
        let patch = Patch::new(width, height, (0..width * height).map(value).collect()).expect("a patch");
        let found = Neighbourhoods::new(&[patch.clone(), patch.clone()], 7, Some(4.0)).expect("squares");
        assert_eq!((found.sigmas.count, found.sigmas.freedom), (2 * 30 * 20, 46.0));
        assert!((found.noise.variance - 4.0).abs() < 8.0 * found.noise.error, "{:?}", found.noise);
        assert_eq!(found.chi_squared.expect("known").freedom, 1200.0 * 46.0);
        let once = Neighbourhoods::new(std::slice::from_ref(&patch), 7, Some(4.0)).expect("squares");
        assert!(once.sigmas.p_value > 1e-3, "{}", once.sigmas.p_value);
        assert!(Neighbourhoods::new(&[patch], 141, None).is_none());
    }
}
