//! Directional albedo of one bounce, reflected and refracted, at a rough interface of two clear media.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::grid::{Grid, GridRow, locate, mix, node};
use super::lattice::{LATTICE, from_cosine, lattice_mean};
use super::reflection::Azimuthal;
use crate::bsdf::microfacet::Ggx;
use crate::bsdf::refraction::bounce;

/// Tabulated indices: from 1 to this, even in √(n − 1), since total reflection sets in at the cosine √(n² − 1)/n.
pub(super) const LARGEST_INDEX: f32 = 3.0;
pub(super) const INDICES: usize = 13;
/// Nodes along √α and √μ where roughness is the same along x and y.
pub(super) const ALPHAS: usize = 16;
pub(super) const MUS: usize = 16;

/// Indices and roughnesses of the table for anisotropic facets, which is integrated with fewer points.
pub(super) const ANISOTROPIC_INDICES: usize = 9;
pub(super) const ANISOTROPIC_ALPHAS: usize = 12;
const ANISOTROPIC_LATTICE: (usize, usize) = (233, 144);

/// The albedos of an interface, for light from either side.
pub(in crate::bsdf) struct GlassRow {
    facets: Facets,
    far_is_rarer: bool,
}

enum Facets {
    /// Isotropic roughness, between two tabulated indices.
    Isotropic { below: GridRow<Vec2>, above: GridRow<Vec2>, fraction: f32 },
    /// Anisotropic roughness, between two indices and four pairs of roughnesses.
    Anisotropic([Corner; 8]),
}

/// A tabulated pair of roughnesses with its weight. The table has α_x ≤ α_y alone.
#[derive(Clone, Copy)]
struct Corner {
    entry: &'static Azimuthal,
    is_turned: bool,
    weight: f32,
}

impl GlassRow {
    /// Returns the albedos for the index `eta` of the far side over the near one.
    #[inline]
    pub(in crate::bsdf) fn of(eta: f32, distribution: Ggx) -> Self {
        let position = position(eta);
        let [x, y] = distribution.alpha();
        let facets = if x == y {
            let table = isotropic();
            let (i, fraction) = locate(position, INDICES);
            Facets::Isotropic { below: table[i].row(x), above: table[i + 1].row(x), fraction }
        } else {
            let positions = [
                locate(position, ANISOTROPIC_INDICES),
                locate(x.sqrt(), ANISOTROPIC_ALPHAS),
                locate(y.sqrt(), ANISOTROPIC_ALPHAS),
            ];
            let table = anisotropic();
            Facets::Anisotropic(std::array::from_fn(|corner| {
                let mut weight = 1.0;
                let [n, i, j] = std::array::from_fn(|axis| {
                    let (node, fraction) = positions[axis];
                    let up = corner >> axis & 1;
                    weight *= if up == 1 { fraction } else { 1.0 - fraction };
                    node + up
                });
                Corner {
                    entry: &table[(n * ANISOTROPIC_ALPHAS + i.min(j)) * ANISOTROPIC_ALPHAS + i.max(j)],
                    is_turned: i > j,
                    weight,
                }
            }))
        };
        Self { facets, far_is_rarer: eta < 1.0 }
    }

    /// Directional albedos for light from the near side and from the far one, each for a direction whose cosine to the
    /// surface and azimuth are those of `w`, above it.
    #[inline]
    pub(in crate::bsdf) fn directional(&self, w: Vec3) -> [f32; 2] {
        self.sides(match &self.facets {
            Facets::Isotropic { below, above, fraction } => {
                mix(below.directional(w.z), above.directional(w.z), *fraction)
            }
            Facets::Anisotropic(corners) => {
                let turned = Vec3::new(w.y, w.x, w.z);
                corners.iter().map(|c| c.entry.directional(if c.is_turned { turned } else { w }) * c.weight).sum()
            }
        })
    }

    /// Mean albedos over the hemisphere, for light from the near side and from the far one.
    #[inline]
    pub(in crate::bsdf) fn mean(&self) -> [f32; 2] {
        self.sides(match &self.facets {
            Facets::Isotropic { below, above, fraction } => mix(below.mean(), above.mean(), *fraction),
            Facets::Anisotropic(corners) => corners.iter().map(|c| c.entry.mean * c.weight).sum(),
        })
    }

    #[inline]
    fn sides(&self, v: Vec2) -> [f32; 2] {
        if self.far_is_rarer { [v.y, v.x] } else { [v.x, v.y] }
    }
}

/// Position of an index, or its inverse, among the tabulated ones, 0–1.
#[inline]
pub(super) fn position(eta: f32) -> f32 {
    let index = if eta < 1.0 { 1.0 / eta } else { eta };
    ((index - 1.0) / (LARGEST_INDEX - 1.0)).max(0.0).sqrt()
}

/// The index of a node.
pub(super) fn index(i: usize, nodes: usize) -> f32 {
    1.0 + node(i, nodes).powi(2) * (LARGEST_INDEX - 1.0)
}

/// Part of the light from `wo` that one bounce keeps, `wo` on the rarer side and on the denser one.
fn bounced(eta: f32, distribution: Ggx, wo: Vec3, turn: f32, lattice: (usize, usize)) -> Vec2 {
    if distribution.is_smooth() {
        return Vec2::ONE;
    }
    let mean = |eta| lattice_mean(turn, lattice, |u| bounce(eta, distribution, wo, u).power());
    Vec2::new(mean(eta), mean(1.0 / eta))
}

pub(super) fn isotropic() -> &'static [Grid<Vec2>] {
    static TABLE: OnceLock<Vec<Grid<Vec2>>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let of_index = |i: usize| {
            Grid::new(ALPHAS, MUS, |alpha, mu| {
                bounced(index(i, INDICES), Ggx::new(alpha, alpha), from_cosine(mu), 0.5, LATTICE)
            })
        };
        (0..INDICES).map(of_index).collect()
    })
}

/// Tables by index, smaller and larger roughness; entries of which the first is the larger one are never asked for.
pub(super) fn anisotropic() -> &'static [Azimuthal] {
    static TABLE: OnceLock<Vec<Azimuthal>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let alpha = |i: usize| node(i, ANISOTROPIC_ALPHAS).powi(2);
        let entry = |i: usize| {
            let (n, i, j) = (
                i / ANISOTROPIC_ALPHAS / ANISOTROPIC_ALPHAS,
                i / ANISOTROPIC_ALPHAS % ANISOTROPIC_ALPHAS,
                i % ANISOTROPIC_ALPHAS,
            );
            if i > j {
                return Azimuthal::new(|_| Vec2::ZERO);
            }
            let (eta, distribution) = (index(n, ANISOTROPIC_INDICES), Ggx::new(alpha(i), alpha(j)));
            Azimuthal::new(|w| bounced(eta, distribution, w, 1.0, ANISOTROPIC_LATTICE))
        };
        (0..ANISOTROPIC_INDICES * ANISOTROPIC_ALPHAS * ANISOTROPIC_ALPHAS).map(entry).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interfaces_are_interpolated_well_between_their_nodes() {
        // From nearly along the surface to the normal.
        let mus = [0.05f32, 0.2, 0.5, 0.85, 1.0];
        let error = |eta: f32, x: f32, y: f32| {
            let mut largest = 0.0f32;
            let ggx = Ggx::new(x, y);
            for mu in mus {
                for phi in [0.0f32, 0.5, 1.3] {
                    let w = from_cosine(mu);
                    let w = Vec3::new(w.x * phi.cos(), w.x * phi.sin(), w.z);
                    let fine = bounced(eta, ggx, w, 1.0, (6765, 4181));
                    let [near, far] = GlassRow::of(eta, ggx).directional(w);
                    largest = largest.max((near - fine.x).abs()).max((far - fine.y).abs());
                    let [far, near] = GlassRow::of(1.0 / eta, ggx).directional(w);
                    largest = largest.max((near - fine.x).abs()).max((far - fine.y).abs());
                }
            }
            largest
        };
        let isotropic = [1.33, 1.5, 1.9, 2.4].map(|eta| [0.15, 0.3, 0.6, 0.95].map(|a| error(eta, a, a)));
        let anisotropic = [1.33, 1.5, 1.9, 2.4]
            .map(|eta| [[0.5, 0.9], [0.3, 0.87], [0.9, 0.2], [0.1, 0.5]].map(|[x, y]| error(eta, x, y)));
        let largest = |errors: [[f32; 4]; 4]| errors.into_iter().flatten().fold(0.0, f32::max);
        // Linear interpolation, whose error falls with the square of the step. The table of anisotropic facets has
        // steps in α up to twice as long and, where α_x is far from α_y, few in azimuth: it is worst there.
        assert!(largest(isotropic) < 6e-3, "{isotropic:?}");
        assert!(largest(anisotropic) < 0.045, "{anisotropic:?}");
    }
}
