//! What a choice among lights gives.

/// A chosen light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    /// Its handle.
    pub(crate) light: u32,
    /// Probability of the choice.
    pub(crate) probability: f32,
    /// Remainder of the random number that chose, in [0, 1) again.
    pub(crate) rest: f32,
}

impl Choice {
    /// The same with a number that chose between two kinds of lights before.
    #[inline]
    pub(super) fn within(self, part: f32) -> Self {
        Self { probability: self.probability * part, ..self }
    }
}
