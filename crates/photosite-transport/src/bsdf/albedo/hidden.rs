//! Part of a lobe that the layer above hides.

use std::sync::OnceLock;

use glam::Vec2;

use super::grid::{Grid, GridRow, locate, mix, node};
use super::lattice::{from_cosine, integrate};
use super::reflection::{Albedo, isotropic, schlick_parts};
use super::sheen::{position, sheen_grid};
use crate::bsdf::microfacet::Ggx;

/// Reflectance at normal incidence of a coat, whose index glTF fixes at 1.5.
pub(in crate::bsdf) const COAT_F0: f32 = 0.04;

/// The part of a GGX lobe that a layer of albedo E above it hides: ∫ f·max(E(wo), E(wi))·cos θᵢ dωᵢ over ∫ f·cos θᵢ
/// dωᵢ. Anisotropic facets count by their mean roughness: the ratio depends on it far less than either integral.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct Hidden {
    below: GridRow<Vec2>,
    above: GridRow<Vec2>,
    fraction: f32,
    whole: GridRow<Vec2>,
}

/// Part of a lobe hidden by the layer above for one direction, by Schlick's parameters.
#[derive(Clone, Copy)]
pub(in crate::bsdf) struct HiddenPart {
    hidden: Albedo,
    whole: Albedo,
}

impl HiddenPart {
    /// Hidden part of facets with reflectance `f0` at normal incidence.
    #[inline]
    pub(in crate::bsdf) fn at(self, f0: f32) -> f32 {
        self.hidden.at(f0) / self.whole.at(f0).max(f32::MIN_POSITIVE)
    }
}

impl Hidden {
    /// Part hidden by a coat of roughness `coat`.
    #[inline]
    pub(in crate::bsdf) fn by_coat(coat: Ggx, base: Ggx) -> Self {
        Self::of(Self::of_coats(), coat.mean_alpha(), base)
    }

    /// Part hidden by sheen of roughness α `sheen`.
    #[inline]
    pub(in crate::bsdf) fn by_sheen(sheen: f32, base: Ggx) -> Self {
        Self::of(Self::of_sheens(), position(sheen), base)
    }

    /// Nodes along the roughness of either layer and along √μ.
    pub(super) const NODES: usize = 16;

    /// Tables by the roughness of a coat.
    pub(super) fn of_coats() -> &'static [Grid<Vec2>] {
        static TABLE: OnceLock<Vec<Grid<Vec2>>> = OnceLock::new();
        TABLE.get_or_init(|| {
            let layer = |alpha| {
                let row = isotropic().row(alpha);
                move |mu| Albedo(row.directional(mu)).at(COAT_F0)
            };
            Self::table(layer)
        })
    }

    /// Tables by the place of sheen in its own.
    pub(super) fn of_sheens() -> &'static [Grid<Vec2>] {
        static TABLE: OnceLock<Vec<Grid<Vec2>>> = OnceLock::new();
        TABLE.get_or_init(|| {
            let layer = |position| {
                let row = sheen_grid().row(position);
                move |mu| row.directional(mu).y
            };
            Self::table(layer)
        })
    }

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
    pub(in crate::bsdf) fn directional(&self, mu: f32) -> HiddenPart {
        let hidden = Albedo(mix(self.below.directional(mu), self.above.directional(mu), self.fraction));
        HiddenPart { hidden, whole: Albedo(self.whole.directional(mu)) }
    }

    #[inline]
    pub(in crate::bsdf) fn mean(&self) -> HiddenPart {
        let hidden = Albedo(mix(self.below.mean(), self.above.mean(), self.fraction));
        HiddenPart { hidden, whole: Albedo(self.whole.mean()) }
    }
}
