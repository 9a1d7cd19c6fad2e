//! Result of a choice among lights.

/// A chosen light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    /// Handle of the chosen light.
    pub(crate) light: u32,
    /// Probability of the choice.
    pub(crate) probability: f32,
    /// Remainder of the random number that chose, in [0, 1) again.
    pub(crate) rest: f32,
}

impl Choice {
    /// Returns the choice within a kind of lights that was chosen with probability `part` before.
    #[inline]
    pub(super) fn within(self, part: f32) -> Self {
        Self { probability: self.probability * part, ..self }
    }
}
