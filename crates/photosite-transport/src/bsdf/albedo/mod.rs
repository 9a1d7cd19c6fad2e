//! How much lobes reflect in all, tabulated: what is left for whatever lies under them.
//!
//! The directional albedo E(w) = ∫ f·cos θᵢ dωᵢ of a GGX reflection lobe with Schlick's Fresnel factor
//! R = F₀ + (F₉₀ − F₀)(1 − cos θ)⁵ is linear in F₀ and F₉₀, E = F₀·A(w, α) + F₉₀·B(w, α)
//! ([Karis13](photosite_core::references#karis13)), so two tables serve all materials. For any other factor, such as
//! that of a thin film, E = Σⱼ R(cⱼ)·Wⱼ(w, α) with the factor interpolated between its values at eight cosines cⱼ.
//!
//! Tables are integrated when first used.

mod glass;
mod grid;
mod thin_film_glass;

use std::f32::consts::{FRAC_2_PI, FRAC_PI_2};
use std::sync::OnceLock;

use glam::{Vec2, Vec3, Vec4};

use super::fresnel::schlick_weight;
use super::microfacet::Ggx;
use super::sheen;
pub(super) use glass::GlassRow;
pub(super) use grid::node;
use grid::{Grid, GridRow, cosine_mean, locate, mix};
pub(super) use thin_film_glass::FilmGlassRow;

/// Points of the Fibonacci lattice that an entry is integrated with, and its generator. Against 28 657 points the
/// entries are right to 9e-4 for F₀ = 0.04 (mean 1e-4), to 2e-3 for F₀ = 1.
const LATTICE: (usize, usize) = (610, 377);

/// Reflectance at normal incidence of a coat, whose index glTF fixes at 1.5.
pub(super) const COAT_F0: f32 = 0.04;

/// An albedo as a function of Schlick's parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Albedo(Vec2);

impl Albedo {
    /// F₀·A + B, for F₉₀ = 1.
    #[inline]
    pub(super) fn at(self, f0: f32) -> f32 {
        f0 * self.0.x + self.0.y
    }

    /// A and B.
    #[inline]
    pub(super) fn parts(self) -> [f32; 2] {
        self.0.to_array()
    }
}

/// The albedo of a GGX lobe of one roughness.
#[derive(Clone, Copy)]
pub(super) enum Row {
    /// The same roughness along x and y.
    Isotropic(GridRow<Vec2>),
    /// Between four tabulated pairs of roughnesses, with their weights.
    Anisotropic([(&'static Azimuthal, f32); 4]),
}

impl Row {
    #[inline]
    pub(super) fn of(distribution: Ggx) -> Self {
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

    /// E for light from `w`, above the surface.
    #[inline]
    pub(super) fn directional(&self, w: Vec3) -> Albedo {
        match self {
            Self::Isotropic(row) => Albedo(row.directional(w.z)),
            Self::Anisotropic(corners) => {
                Albedo(corners.iter().map(|(entry, weight)| entry.directional(w) * *weight).sum())
            }
        }
    }

    /// Ē, for light from everywhere.
    #[inline]
    pub(super) fn mean(&self) -> Albedo {
        match self {
            Self::Isotropic(row) => Albedo(row.mean()),
            Self::Anisotropic(corners) => Albedo(corners.iter().map(|(entry, weight)| entry.mean * *weight).sum()),
        }
    }
}

/// Nodes of the isotropic table along each axis.
const NODES: usize = 32;

fn isotropic() -> &'static Grid<Vec2> {
    static TABLE: OnceLock<Grid<Vec2>> = OnceLock::new();
    TABLE.get_or_init(|| Grid::new(NODES, NODES, |alpha, mu| reflected(Ggx::new(alpha, alpha), from_cosine(mu))))
}

/// Nodes of the anisotropic table: along √α of each axis, along √μ, and over a quarter of a turn.
const ALPHAS: usize = 14;
const MUS: usize = 16;
const PHIS: usize = 5;

/// A pair of albedos at one pair of roughnesses, by azimuth and cosine.
pub(super) struct Azimuthal {
    directional: [[Vec2; MUS]; PHIS],
    mean: Vec2,
}

impl Azimuthal {
    fn new(f: impl Fn(Vec3) -> Vec2) -> Self {
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
    fn directional(&self, w: Vec3) -> Vec2 {
        let (i, s) = locate(w.y.abs().atan2(w.x.abs()) * FRAC_2_PI, PHIS);
        let (j, t) = locate(w.z.max(0.0).sqrt(), MUS);
        let along = |row: &[Vec2; MUS]| mix(row[j], row[j + 1], t);
        mix(along(&self.directional[i]), along(&self.directional[i + 1]), s)
    }
}

fn anisotropic() -> &'static [Azimuthal] {
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

/// The part of a GGX lobe that a layer of albedo E above it hides: ∫ f·max(E(wo), E(wi))·cos θᵢ dωᵢ over ∫ f·cos θᵢ
/// dωᵢ. Anisotropic facets count by their mean roughness: the ratio depends on it far less than either integral.
#[derive(Clone, Copy)]
pub(super) struct Hidden {
    below: GridRow<Vec2>,
    above: GridRow<Vec2>,
    fraction: f32,
    whole: GridRow<Vec2>,
}

/// That part for one direction, by Schlick's parameters.
#[derive(Clone, Copy)]
pub(super) struct HiddenPart {
    hidden: Albedo,
    whole: Albedo,
}

impl HiddenPart {
    /// Of facets of reflectance `f0` at normal incidence.
    #[inline]
    pub(super) fn at(self, f0: f32) -> f32 {
        self.hidden.at(f0) / self.whole.at(f0).max(f32::MIN_POSITIVE)
    }
}

impl Hidden {
    /// By a coat of roughness `coat`.
    #[inline]
    pub(super) fn by_coat(coat: Ggx, base: Ggx) -> Self {
        static TABLE: OnceLock<Vec<Grid<Vec2>>> = OnceLock::new();
        let table = TABLE.get_or_init(|| {
            let layer = |alpha| {
                let row = isotropic().row(alpha);
                move |mu| Albedo(row.directional(mu)).at(COAT_F0)
            };
            Self::table(layer)
        });
        Self::of(table, coat.mean_alpha(), base)
    }

    /// By sheen of roughness α `sheen`.
    #[inline]
    pub(super) fn by_sheen(sheen: f32, base: Ggx) -> Self {
        static TABLE: OnceLock<Vec<Grid<Vec2>>> = OnceLock::new();
        let table = TABLE.get_or_init(|| {
            let layer = |alpha| {
                let row = sheen_grid().row(alpha);
                move |mu| row.directional(mu)
            };
            Self::table(layer)
        });
        Self::of(table, sheen, base)
    }

    /// Nodes along the roughness of either layer and along √μ.
    const NODES: usize = 16;

    fn table<L: Fn(f32) -> f32>(layer: impl Fn(f32) -> L) -> Vec<Grid<Vec2>> {
        let of_layer = |i: usize| {
            let albedo = layer(node(i, Self::NODES) * node(i, Self::NODES));
            Grid::new(Self::NODES, Self::NODES, |alpha, mu| {
                let own = albedo(mu);
                integrate(Ggx::new(alpha, alpha), from_cosine(mu), |wi, cos_facet| {
                    schlick_parts(cos_facet) * albedo(wi.z).max(own)
                })
            })
        };
        (0..Self::NODES).map(of_layer).collect()
    }

    #[inline]
    fn of(table: &'static [Grid<Vec2>], layer: f32, base: Ggx) -> Self {
        let (i, fraction) = locate(layer.sqrt(), table.len());
        let row = |i: usize| table[i].row(base.mean_alpha());
        Self { below: row(i), above: row(i + 1), fraction, whole: isotropic().row(base.mean_alpha()) }
    }

    #[inline]
    pub(super) fn directional(&self, mu: f32) -> HiddenPart {
        let hidden = Albedo(mix(self.below.directional(mu), self.above.directional(mu), self.fraction));
        HiddenPart { hidden, whole: Albedo(self.whole.directional(mu)) }
    }

    #[inline]
    pub(super) fn mean(&self) -> HiddenPart {
        let hidden = Albedo(mix(self.below.mean(), self.above.mean(), self.fraction));
        HiddenPart { hidden, whole: Albedo(self.whole.mean()) }
    }
}

/// The albedo of sheen of one roughness α, for a colour of 1.
#[derive(Clone, Copy)]
pub(super) struct SheenRow(GridRow<f32>);

impl SheenRow {
    #[inline]
    pub(super) fn of(alpha: f32) -> Self {
        Self(sheen_grid().row(alpha))
    }

    #[inline]
    pub(super) fn directional(&self, mu: f32) -> f32 {
        self.0.directional(mu)
    }

    #[inline]
    pub(super) fn mean(&self) -> f32 {
        self.0.mean()
    }
}

fn sheen_grid() -> &'static Grid<f32> {
    static TABLE: OnceLock<Grid<f32>> = OnceLock::new();
    TABLE.get_or_init(|| Grid::new(NODES, NODES, sheen::albedo))
}

/// Number of cosines at which the reflectance of a film is sampled, even from 0 to 1.
pub(super) const FILM_NODES: usize = 8;

/// Weights Wⱼ of the reflectances at the cosines j/7.
#[derive(Clone, Copy)]
pub(super) struct FilmWeights([Vec4; 2]);

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
    pub(super) fn hat(cos: f32) -> Self {
        let (i, t) = locate(cos, FILM_NODES);
        let weight = |j: usize| if j == i { 1.0 - t } else { f32::from(u8::from(j == i + 1)) * t };
        Self([0, 4].map(|j| Vec4::new(weight(j), weight(j + 1), weight(j + 2), weight(j + 3))))
    }

    /// Weights of the mean over the hemisphere, ∫2μ·R(μ) dμ.
    #[inline]
    pub(super) fn cosine_mean() -> Self {
        // Of a hat of half width h about c: 2c·h; half a hat about 0 and about 1: h²/3 and h − h²/3.
        let h = 1.0 / (FILM_NODES - 1) as f32;
        let weight = |j: usize| match j {
            0 => h * h / 3.0,
            _ if j == FILM_NODES - 1 => h - h * h / 3.0,
            _ => 2.0 * h * (h * j as f32),
        };
        Self([0, 4].map(|j| Vec4::new(weight(j), weight(j + 1), weight(j + 2), weight(j + 3))))
    }

    /// Their sum.
    #[inline]
    pub(super) fn sum(&self) -> f32 {
        (self.0[0] + self.0[1]).element_sum()
    }

    /// Weight of node `j`.
    #[inline]
    pub(super) fn at(&self, j: usize) -> f32 {
        self.0[j / 4][j % 4]
    }
}

/// The weights for a GGX lobe of one roughness, directional and mean.
#[derive(Clone, Copy)]
pub(super) struct FilmRow(GridRow<FilmWeights>);

impl FilmRow {
    #[inline]
    pub(super) fn of(distribution: Ggx) -> Self {
        static TABLE: OnceLock<Grid<FilmWeights>> = OnceLock::new();
        let table = TABLE.get_or_init(|| {
            Grid::new(16, NODES, |alpha, mu| {
                if alpha == 0.0 {
                    return FilmWeights::hat(mu);
                }
                integrate(Ggx::new(alpha, alpha), from_cosine(mu), |_, cos_facet| FilmWeights::hat(cos_facet))
            })
        });
        Self(table.row(distribution.mean_alpha()))
    }

    #[inline]
    pub(super) fn directional(&self, mu: f32) -> FilmWeights {
        self.0.directional(mu)
    }

    #[inline]
    pub(super) fn mean(&self) -> FilmWeights {
        self.0.mean()
    }
}

/// A direction of cosine `mu` in the xz plane. Along the surface itself nothing is defined, but the limit is.
fn from_cosine(mu: f32) -> Vec3 {
    let mu = mu.max(1e-5);
    Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu)
}

/// The weights of F₀ and of F₉₀.
fn schlick_parts(cos_facet: f32) -> Vec2 {
    let white = schlick_weight(cos_facet);
    Vec2::new(1.0 - white, white)
}

/// A and B.
fn reflected(distribution: Ggx, wo: Vec3) -> Vec2 {
    integrate(distribution, wo, |_, cos_facet| schlick_parts(cos_facet))
}

/// ∫ k·g(wi, cosine to the facet)·cos θᵢ dωᵢ, k the reflection kernel, by a lattice rule over the square that
/// [`Ggx::sample_reflection`] maps to directions: the integrand is then G₂/G₁ times g, and 0 where facets reflect below
/// the horizon.
fn integrate<T>(distribution: Ggx, wo: Vec3, g: impl Fn(Vec3, f32) -> T) -> T
where
    T: grid::Value,
{
    if distribution.is_smooth() {
        return g(Vec3::new(-wo.x, -wo.y, wo.z), wo.z);
    }
    let [x, y] = distribution.alpha();
    // In the plane of symmetry half a turn is enough.
    let turn = if x == y || wo.y == 0.0 { 0.5 } else { 1.0 };
    lattice_mean(turn, LATTICE, |u| match distribution.sample_reflection(wo, u) {
        Some((wi, kernel)) => g(wi, kernel.cos_facet) * (kernel.value * wi.z / kernel.pdf),
        None => g(Vec3::Z, 1.0) * 0.0,
    })
}

/// Mean over the lattice points of the square, its first axis cut off at `turn`.
fn lattice_mean<T: grid::Value>(turn: f32, (points, generator): (usize, usize), f: impl Fn([f32; 2]) -> T) -> T {
    let unit = |i: usize| (i as f32 + 0.5) / points as f32;
    let at = |i: usize| f([turn * unit(i * generator % points), unit(i)]);
    (1..points).fold(at(0), |sum, i| sum + at(i)) * (1.0 / points as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

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
