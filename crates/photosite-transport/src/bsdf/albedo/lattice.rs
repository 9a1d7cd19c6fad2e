//! Integrals over the directions of a lobe, by a lattice rule.

use glam::Vec3;

use super::grid::Value;
use crate::bsdf::microfacet::Ggx;

/// Points of the Fibonacci lattice that an entry is integrated with, and its generator. Against 28 657 points the
/// entries are right to 9e-4 for F₀ = 0.04 (mean 1e-4), to 2e-3 for F₀ = 1.
pub(super) const LATTICE: (usize, usize) = (610, 377);

/// A direction of cosine `mu` in the xz plane. Along the surface itself nothing is defined, but the limit is.
pub(super) fn from_cosine(mu: f32) -> Vec3 {
    let mu = mu.max(1e-5);
    Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu)
}

/// Integral ∫ k·g(wi, cosine to the facet)·cos θᵢ dωᵢ, k the reflection kernel, by a lattice rule over the square that
/// [`Ggx::sample_reflection`] maps to directions: the integrand is then G₂/G₁ times g, and 0 where facets reflect below
/// the horizon.
pub(super) fn integrate<T>(distribution: Ggx, wo: Vec3, g: impl Fn(Vec3, f32) -> T) -> T
where
    T: Value,
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
pub(super) fn lattice_mean<T: Value>(turn: f32, (points, generator): (usize, usize), f: impl Fn([f32; 2]) -> T) -> T {
    let unit = |i: usize| (i as f32 + 0.5) / points as f32;
    let at = |i: usize| f([turn * unit(i * generator % points), unit(i)]);
    (1..points).fold(at(0), |sum, i| sum + at(i)) * (1.0 / points as f32)
}
