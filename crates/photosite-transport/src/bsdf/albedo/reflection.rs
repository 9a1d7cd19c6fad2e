//! The directional albedo of a GGX reflection lobe with Schlick's Fresnel factor.

use std::f32::consts::{FRAC_2_PI, FRAC_PI_2};
use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::grid::{Grid, GridRow, cosine_mean, locate, mix, node};
use super::lattice::{from_cosine, integrate};
use crate::bsdf::fresnel::schlick_weight;
use crate::bsdf::microfacet::Ggx;

/// An albedo as a function of Schlick's parameters.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Albedo(pub(super) Vec2);

impl Albedo {
    /// F₀·A + B, for F₉₀ = 1.
    #[inline]
    pub(in crate::bsdf) fn at(self, f0: f32) -> f32 {
        f0 * self.0.x + self.0.y
    }

    /// A and B.
    #[inline]
    pub(in crate::bsdf) fn parts(self) -> [f32; 2] {
        self.0.to_array()
    }
}

/// The albedo of a GGX lobe of one roughness.
#[derive(Clone, Copy)]
pub(in crate::bsdf) enum Row {
    /// Isotropic roughness: the same α along x and y.
    Isotropic(GridRow<Vec2>),
    /// Anisotropic roughness, between four tabulated pairs of roughnesses with their weights.
    Anisotropic([(&'static Azimuthal, f32); 4]),
}

impl Row {
    #[inline]
    pub(in crate::bsdf) fn of(distribution: Ggx) -> Self {
        let [x, y] = distribution.alpha();
        if x == y {
            return Self::Isotropic(isotropic().row(x));
        }
        let table = anisotropic();
        let ((i, s), (j, t)) = (locate(x.sqrt(), ALPHAS), locate(y.sqrt(), ALPHAS));
        let at = |i: usize, j: usize, weight: f32| (&table[i * ALPHAS + j], weight);
        Self::Anisotropic([
            at(i, j, (1.0 - s) * (1.0 - t)),
            at(i + 1, j, s * (1.0 - t)),
            at(i, j + 1, (1.0 - s) * t),
            at(i + 1, j + 1, s * t),
        ])
    }

    /// Directional albedo E for light from `w`, above the surface.
    #[inline]
    pub(in crate::bsdf) fn directional(&self, w: Vec3) -> Albedo {
        match self {
            Self::Isotropic(row) => Albedo(row.directional(w.z)),
            Self::Anisotropic(corners) => {
                Albedo(corners.iter().map(|(entry, weight)| entry.directional(w) * *weight).sum())
            }
        }
    }

    /// Mean albedo Ē over the hemisphere.
    #[inline]
    pub(in crate::bsdf) fn mean(&self) -> Albedo {
        match self {
            Self::Isotropic(row) => Albedo(row.mean()),
            Self::Anisotropic(corners) => Albedo(corners.iter().map(|(entry, weight)| entry.mean * *weight).sum()),
        }
    }
}

/// Nodes of the isotropic table along each axis.
pub(super) const NODES: usize = 32;

pub(super) fn isotropic() -> &'static Grid<Vec2> {
    static TABLE: OnceLock<Grid<Vec2>> = OnceLock::new();
    TABLE.get_or_init(|| Grid::new(NODES, NODES, |alpha, mu| reflected(Ggx::new(alpha, alpha), from_cosine(mu))))
}

/// Nodes of the anisotropic table: along √α of each axis, along √μ, and over a quarter of a turn.
pub(super) const ALPHAS: usize = 14;
pub(super) const MUS: usize = 16;
pub(super) const PHIS: usize = 5;

/// A pair of albedos at one pair of roughnesses, by azimuth and cosine.
pub(in crate::bsdf) struct Azimuthal {
    pub(super) directional: [[Vec2; MUS]; PHIS],
    pub(super) mean: Vec2,
}

impl Azimuthal {
    pub(super) fn new(f: impl Fn(Vec3) -> Vec2) -> Self {
        let directional: [[Vec2; MUS]; PHIS] = std::array::from_fn(|i| {
            let (sin, cos) = (node(i, PHIS) * FRAC_PI_2).sin_cos();
            std::array::from_fn(|j| {
                let w = from_cosine(node(j, MUS) * node(j, MUS));
                f(Vec3::new(w.x * cos, w.x * sin, w.z))
            })
        });
        let means = directional.map(|along_mu| cosine_mean(&along_mu));
        // The trapezoidal rule is exact for what is interpolated linearly.
        let ends = (means[0] + means[PHIS - 1]) * 0.5;
        let mean = (means[1..PHIS - 1].iter().sum::<Vec2>() + ends) / (PHIS - 1) as f32;
        Self { directional, mean }
    }

    #[inline]
    pub(super) fn directional(&self, w: Vec3) -> Vec2 {
        let (i, s) = locate(w.y.abs().atan2(w.x.abs()) * FRAC_2_PI, PHIS);
        let (j, t) = locate(w.z.max(0.0).sqrt(), MUS);
        let along = |row: &[Vec2; MUS]| mix(row[j], row[j + 1], t);
        mix(along(&self.directional[i]), along(&self.directional[i + 1]), s)
    }
}

pub(super) fn anisotropic() -> &'static [Azimuthal] {
    static TABLE: OnceLock<Vec<Azimuthal>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let alpha = |i: usize| node(i, ALPHAS) * node(i, ALPHAS);
        let entry = |i: usize| {
            let distribution = Ggx::new(alpha(i / ALPHAS), alpha(i % ALPHAS));
            Azimuthal::new(|w| reflected(distribution, w))
        };
        (0..ALPHAS * ALPHAS).map(entry).collect()
    })
}

/// The weights of F₀ and of F₉₀.
pub(super) fn schlick_parts(cos_facet: f32) -> Vec2 {
    let white = schlick_weight(cos_facet);
    Vec2::new(1.0 - white, white)
}

/// A and B.
fn reflected(distribution: Ggx, wo: Vec3) -> Vec2 {
    integrate(distribution, wo, |_, cos_facet| schlick_parts(cos_facet))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::albedo::lattice::lattice_mean;

    #[test]
    fn albedos_are_interpolated_well_between_their_nodes() {
        // Linear interpolation, whose error falls with the square of the step: twice as long for anisotropic facets.
        let isotropic = [[0.15, 0.15], [0.3, 0.3], [0.6, 0.6], [0.95, 0.95]].map(|alpha| (alpha, 6e-3));
        let anisotropic = [[0.5, 0.9], [0.3, 0.87], [0.9, 0.2]].map(|alpha| (alpha, 0.015));
        for ([x, y], tolerance) in isotropic.into_iter().chain(anisotropic) {
            let mut largest = 0.0f32;
            let ggx = Ggx::new(x, y);
            for mu in [0.05f32, 0.2, 0.5, 0.85, 1.0] {
                for phi in [0.0f32, 0.5, 1.3] {
                    let w = from_cosine(mu);
                    let w = Vec3::new(w.x * phi.cos(), w.x * phi.sin(), w.z);
                    let fine = lattice_mean(1.0, (6765, 4181), |u| match ggx.sample_reflection(w, u) {
                        Some((wi, kernel)) => schlick_parts(kernel.cos_facet) * (kernel.value * wi.z / kernel.pdf),
                        None => Vec2::ZERO,
                    });
                    let found = Row::of(ggx).directional(w);
                    for f0 in [0.04, 1.0] {
                        largest = largest.max((found.at(f0) - Albedo(fine).at(f0)).abs());
                    }
                }
            }
            assert!(largest < tolerance, "α {x} {y}: {largest}");
        }
    }

    #[test]
    fn the_mean_is_the_integral_of_what_is_interpolated() {
        for distribution in [0.0, 0.09, 0.3, 1.0].map(|a| Ggx::new(a, a)).into_iter().chain([Ggx::new(0.1, 0.7)]) {
            let row = Row::of(distribution);
            let n = 1000;
            let at = |i: usize| (i as f32 + 0.5) / n as f32;
            let along = |phi: f32| -> f64 {
                let (sin, cos) = phi.sin_cos();
                (0..n)
                    .map(|i| {
                        let w = from_cosine(at(i));
                        f64::from(2.0 * w.z * row.directional(Vec3::new(w.x * cos, w.x * sin, w.z)).at(0.04))
                    })
                    .sum::<f64>()
                    / n as f64
            };
            let mean = (0..64).map(|i| along((i as f32 + 0.5) / 64.0 * FRAC_PI_2)).sum::<f64>() / 64.0;
            // The midpoint rule on 1000 points, of curvature up to 100 near 0: 1e-5.
            assert!((mean - f64::from(row.mean().at(0.04))).abs() < 1e-5, "{distribution:?}");
        }
    }

    #[test]
    fn a_smooth_surface_has_schlicks_albedo() {
        // ∫2μ(1 − μ)⁵ dμ = 1/21; linear interpolation in √μ adds up to h²/8 of the curvature, in all some 1e-4.
        let [scale, bias] = Row::of(Ggx::SMOOTH).mean().parts();
        assert!((bias - 1.0 / 21.0).abs() < 3e-4 && (scale + bias - 1.0).abs() < 1e-6, "{scale} {bias}");
    }
}
