//! The choice of a light to sample.

use super::bounds::LightBounds;
use super::choice::Choice;
use super::light_sample_context::LightSampleContext;
use super::tree::LightTree;
use crate::geometry::Word;
use photosite_core::math::distribution::{AliasTable, rest};

/// Lights that are somewhere are chosen by a tree, those infinitely far by their power, and which of both kinds by the
/// irradiance to be expected of each.
#[derive(Clone, Debug)]
pub(super) struct Selection {
    tree: LightTree,
    /// Handles of the lights infinitely far.
    distant: Vec<u32>,
    among_distant: AliasTable,
    /// Irradiance from all lights infinitely far, in the unit of the tree's importance.
    irradiance: f32,
}

/// Bounds of the probability of either kind, where it shines at all: walls may hide the brighter one.
const LEAST: f32 = 0.1;

impl Selection {
    /// Makes tables for lights with the handles 0, 1, … from the bounds of those that are somewhere, and the irradiance
    /// in the same unit from those infinitely far.
    pub(super) fn new(bounds: &[Option<LightBounds>], distant: &[(u32, f64)]) -> Self {
        let intensity: f64 = bounds.iter().flatten().map(|b| f64::from(b.intensity)).sum();
        let irradiances: Vec<f64> = distant.iter().map(|(_, irradiance)| *irradiance).collect();
        Self {
            tree: LightTree::new(bounds.iter().copied()),
            distant: distant.iter().map(|(light, _)| *light).collect(),
            among_distant: AliasTable::new(&irradiances),
            irradiance: (irradiances.iter().sum::<f64>() / intensity) as f32,
        }
    }

    /// Rank of a light in the tree.
    pub(super) fn rank(&self, light: u32) -> u32 {
        self.tree.rank(light)
    }

    /// Irradiance from all lights infinitely far, in the unit of the tree's importance.
    pub(super) fn irradiance(&self) -> f32 {
        self.irradiance
    }

    /// Nodes of the tree as plain data.
    pub(super) fn tree_words(&self) -> Vec<Word> {
        self.tree.words()
    }

    /// Lights infinitely far as plain data: handle, and the bin of the choice among them.
    pub(super) fn distant_words(&self) -> Vec<Word> {
        let bin = |(&light, [keep, alias, probability]): (&u32, [u32; 3])| [light, keep, alias, probability];
        self.distant.iter().zip(self.among_distant.bin_words()).map(bin).collect()
    }

    /// Probability of a light infinitely far.
    #[inline]
    fn part_of_distant(&self, ctx: &LightSampleContext) -> f32 {
        if self.distant.is_empty() {
            return 0.0;
        }
        if self.tree.is_empty() {
            return 1.0;
        }
        let near = self.tree.importance(ctx);
        if near == 0.0 {
            return 1.0;
        }
        if self.irradiance == 0.0 {
            return 0.0;
        }
        (self.irradiance / (self.irradiance + near)).clamp(LEAST, 1.0 - LEAST)
    }

    /// A light, from a number in [0, 1). `None` where the lights that it leads to cannot reach the point.
    #[inline]
    pub(super) fn sample(&self, ctx: &LightSampleContext, u: f32) -> Option<Choice> {
        if self.distant.is_empty() {
            return self.tree.sample(ctx, u);
        }
        let distant = self.part_of_distant(ctx);
        if u < distant {
            let (entry, probability, rest) = self.among_distant.sample(rest(u, 0.0, distant));
            return Some(Choice { light: self.distant[entry as usize], probability, rest }.within(distant));
        }
        let near = 1.0 - distant;
        Some(self.tree.sample(ctx, rest(u, distant, near))?.within(near))
    }

    /// Probability with which [`Self::sample`] finds a light that is somewhere.
    #[inline]
    pub(super) fn probability(&self, ctx: &LightSampleContext, light: u32) -> f32 {
        let in_tree = self.tree.probability(ctx, light);
        in_tree * (1.0 - self.part_of_distant(ctx))
    }

    /// Probability of choosing the light infinitely far of that number.
    #[inline]
    pub(super) fn probability_of_distant(&self, ctx: &LightSampleContext, number: u32) -> f32 {
        self.among_distant.probability(number) * self.part_of_distant(ctx)
    }
}
