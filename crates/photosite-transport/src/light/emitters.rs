//! Choice among the lights that light paths can start from.

use photosite_core::math::distribution::AliasTable;

/// Choice among the area lights, by their power.
#[derive(Clone, Debug)]
pub(super) struct Emitters {
    /// Alias table of the emitters; `None` where nothing emits.
    table: Option<AliasTable>,
}

impl Emitters {
    /// Builds the table. `powers[i]` is the power of light i, any unit; 0 of lights that are no surfaces.
    pub(super) fn new(powers: &[f64]) -> Self {
        Self { table: powers.iter().any(|&power| power > 0.0).then(|| AliasTable::new(powers)) }
    }

    /// Whether no surface emits.
    pub(super) fn is_empty(&self) -> bool {
        self.table.is_none()
    }

    /// A light by a random number, its probability, and the rest of the number, in [0, 1) again.
    #[inline]
    pub(super) fn sample(&self, u: f32) -> Option<(u32, f32, f32)> {
        Some(self.table.as_ref()?.sample(u))
    }

    /// Probability that [`Self::sample`] gives that light.
    #[inline]
    pub(super) fn probability(&self, light: u32) -> f32 {
        self.table.as_ref().map_or(0.0, |table| table.probability(light))
    }
}
