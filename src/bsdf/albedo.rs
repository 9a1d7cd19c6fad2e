//! How much a GGX reflection lobe with Schlick's Fresnel factor reflects in all, tabulated: what is left for the base
//! under a glossy coat.
//!
//! The directional albedo E(μ) = ∫ f·cos θᵢ dωᵢ for light from the direction of cosine μ is linear in the reflectance F₀
//! at normal incidence, E = F₀·A(μ, α) + B(μ, α) ([Karis13](crate::references#karis13)), so two tables serve all
//! materials. They are integrated when first used, in some milliseconds.
//!
//! Nodes are even in √α, the perceptual roughness, and in √μ, close together at grazing angles where E rises. Between
//! them everything is linear, and the mean albedo Ē = 2∫E(μ)·μ dμ is the exact integral of the interpolated E: light
//! that is shared out by both adds up to what arrived.

use std::sync::OnceLock;

use glam::Vec3;

use super::fresnel::schlick_weight;
use super::microfacet::Ggx;

/// Nodes along each axis.
const NODES: usize = 32;
/// Points of the Fibonacci lattice that an entry is integrated with, and its generator. Against 28 657 points the entries
/// are right to 9e-4 for F₀ = 0.04 (mean 1e-4), to 2e-3 for F₀ = 1.
const LATTICE: (usize, usize) = (610, 377);

/// An albedo as a function of the reflectance at normal incidence.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Albedo {
    /// A, the factor of F₀.
    scale: f32,
    /// B, what is reflected even for F₀ = 0.
    bias: f32,
}

impl Albedo {
    /// F₀·A + B.
    #[inline]
    pub(super) fn at(self, f0: f32) -> f32 {
        f0 * self.scale + self.bias
    }

    #[inline]
    fn mix(self, other: Self, t: f32) -> Self {
        Self { scale: self.scale + t * (other.scale - self.scale), bias: self.bias + t * (other.bias - self.bias) }
    }
}

/// The tables at one roughness.
#[derive(Clone, Copy)]
pub(super) struct Row {
    below: &'static TableRow,
    above: &'static TableRow,
    fraction: f32,
}

impl Row {
    /// For a distribution; where it is anisotropic, for the geometric mean of its α.
    #[inline]
    pub(super) fn of(distribution: Ggx) -> Self {
        let [x, y] = distribution.alpha();
        let (node, fraction) = locate((x * y).sqrt().sqrt());
        let table = table();
        Self { below: &table[node], above: &table[node + 1], fraction }
    }

    /// E for light from the direction of cosine `mu`.
    #[inline]
    pub(super) fn directional(&self, mu: f32) -> Albedo {
        let (node, t) = locate(mu.sqrt());
        let along = |row: &TableRow| row.directional[node].mix(row.directional[node + 1], t);
        along(self.below).mix(along(self.above), self.fraction)
    }

    /// Ē, for light from everywhere.
    #[inline]
    pub(super) fn mean(&self) -> Albedo {
        self.below.mean.mix(self.above.mean, self.fraction)
    }
}

struct TableRow {
    directional: [Albedo; NODES],
    mean: Albedo,
}

/// Place of `x` in 0–1 among the nodes: the node below and the fraction of the way to the next.
#[inline]
fn locate(x: f32) -> (usize, f32) {
    let position = x.clamp(0.0, 1.0) * (NODES - 1) as f32;
    let node = (position as usize).min(NODES - 2);
    (node, position - node as f32)
}

/// The position of a node, 0–1.
fn node(i: usize) -> f32 {
    i as f32 / (NODES - 1) as f32
}

fn table() -> &'static [TableRow; NODES] {
    static TABLE: OnceLock<Box<[TableRow; NODES]>> = OnceLock::new();
    TABLE.get_or_init(|| {
        Box::new(std::array::from_fn(|i| {
            let alpha = node(i) * node(i);
            let directional = std::array::from_fn(|j| integrate(Ggx::new(alpha, alpha), node(j) * node(j)));
            TableRow { directional, mean: mean(&directional) }
        }))
    })
}

/// A and B by a lattice rule over the square that [`Ggx::sample_reflection`] maps to directions: the integrand is then
/// G₂/G₁ times Schlick's factor, between 0 and 1, and 0 where facets reflect below the horizon.
fn integrate(distribution: Ggx, mu: f32) -> Albedo {
    if distribution.is_smooth() {
        let bias = schlick_weight(mu);
        return Albedo { scale: 1.0 - bias, bias };
    }
    // Along the surface itself nothing is defined, but the limit is.
    let mu = mu.max(1e-5);
    let wo = Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
    let (mut scale, mut bias) = (0.0, 0.0);
    let unit = |i: usize| (i as f32 + 0.5) / LATTICE.0 as f32;
    for i in 0..LATTICE.0 {
        // The lobe is symmetric in azimuth: half a turn is enough.
        let u = [0.5 * unit(i * LATTICE.1 % LATTICE.0), unit(i)];
        if let Some((wi, kernel)) = distribution.sample_reflection(wo, u) {
            let weight = kernel.value * wi.z / kernel.pdf;
            let white = schlick_weight(kernel.cos_facet);
            scale += weight * (1.0 - white);
            bias += weight * white;
        }
    }
    Albedo { scale: scale / LATTICE.0 as f32, bias: bias / LATTICE.0 as f32 }
}

/// 2∫E(μ)·μ dμ = 4∫E(t)·t³ dt, t = √μ, of the piecewise linear E.
fn mean(directional: &[Albedo; NODES]) -> Albedo {
    let (mut scale, mut bias) = (0.0, 0.0);
    for i in 0..NODES - 1 {
        let [a, b] = [node(i), node(i + 1)].map(f64::from);
        let (cubes, fourths) = (b.powi(4) - a.powi(4), 0.8 * (b.powi(5) - a.powi(5)));
        // ∫4t³·(b − t)/(b − a) dt and ∫4t³·(t − a)/(b − a) dt.
        let (low, high) = ((b * cubes - fourths) / (b - a), (fourths - a * cubes) / (b - a));
        let [below, above] = [directional[i], directional[i + 1]];
        scale += low * f64::from(below.scale) + high * f64::from(above.scale);
        bias += low * f64::from(below.bias) + high * f64::from(above.bias);
    }
    Albedo { scale: scale as f32, bias: bias as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_the_integral_of_what_is_interpolated() {
        for roughness in [0.0f32, 0.3, 0.55, 1.0] {
            let row = Row::of(Ggx::from_roughness(roughness, 0.0));
            let n = 20_000;
            let mu = |i: usize| (i as f32 + 0.5) / n as f32;
            let mean: f64 = (0..n).map(|i| f64::from(2.0 * mu(i) * row.directional(mu(i)).at(0.04))).sum();
            // f32 interpolation: 1e-7 a term.
            assert!((mean / n as f64 - f64::from(row.mean().at(0.04))).abs() < 1e-6, "roughness {roughness}");
        }
    }

    #[test]
    fn a_smooth_surface_has_schlicks_albedo() {
        // ∫2μ(1 − μ)⁵ dμ = 1/21; linear interpolation in √μ adds up to h²/8 of the curvature, in all some 1e-4.
        let mean = Row::of(Ggx::SMOOTH).mean();
        assert!((mean.bias - 1.0 / 21.0).abs() < 3e-4 && (mean.scale + mean.bias - 1.0).abs() < 1e-6, "{mean:?}");
    }
}
