//! The stages of the sensor by name, and which of them take part in an exposure.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A physical effect between mean electrons and digital numbers that can be left out, in the order of
/// [`expose`](super::expose()). Its number keys its random numbers and is part of what a seed means: it stays when others
/// come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Pixels that respond a little more or less to light than others (PRNU).
    PhotoResponse = 1,
    /// Whole photo-electrons, freed at random.
    ShotNoise = 2,
    /// Thermal electrons, freed at random.
    DarkCurrent = 3,
    /// The end of what a pixel can hold.
    FullWell = 6,
    /// Pixels whose read-out starts from an offset of their own (DSNU).
    DarkOffset = 4,
    /// Noise of the amplifiers.
    ReadNoise = 5,
}

impl Stage {
    /// All stages, in the order of the chain.
    pub const ALL: [Self; 6] =
        [Self::PhotoResponse, Self::ShotNoise, Self::DarkCurrent, Self::FullWell, Self::DarkOffset, Self::ReadNoise];
}

/// Which stages take part. Leaving one out leaves the random numbers of all others as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stages(u64);

impl Stages {
    /// The real sensor.
    pub const ALL: Self = Self::only(&Stage::ALL);
    /// Nothing but gain and converter.
    pub const NONE: Self = Self(0);

    /// These stages alone.
    pub const fn only(stages: &[Stage]) -> Self {
        let mut set = Self::NONE;
        let mut i = 0;
        while i < stages.len() {
            set = set.with(stages[i]);
            i += 1;
        }
        set
    }

    /// One more stage.
    #[must_use]
    pub const fn with(self, stage: Stage) -> Self {
        Self(self.0 | 1 << stage as u32)
    }

    /// All of these but one.
    #[must_use]
    pub const fn without(self, stage: Stage) -> Self {
        Self(self.0 & !(1 << stage as u32))
    }

    /// Whether a stage takes part.
    pub const fn has(self, stage: Stage) -> bool {
        self.0 & 1 << stage as u32 != 0
    }
}

impl Default for Stages {
    fn default() -> Self {
        Self::ALL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_has_a_number_and_a_name_of_its_own() {
        for (i, a) in Stage::ALL.into_iter().enumerate() {
            assert!((a as u32) < u64::BITS);
            for b in Stage::ALL.into_iter().skip(i + 1) {
                assert_ne!(a as u32, b as u32, "{a:?} {b:?}");
            }
            assert!(!Stages::ALL.without(a).has(a) && Stages::NONE.with(a).has(a) && Stages::ALL.has(a));
            assert_eq!(Stages::ALL.without(a).with(a), Stages::ALL);
        }
    }
}
