//! What of a render does not stand in its capture.

use std::ops::Range;
use std::path::Path;

use super::light::Light;
use super::monitor::Monitor;
use super::parts::Parts;
use super::strips::FilmMemory;

/// Where the light of a render comes from.
pub enum LightSource<'a> {
    /// All samples are traced.
    Traced,
    /// Some samples of each pixel are traced, which make no image yet.
    Part(Range<u32>),
    /// Parts that were traced before are merged.
    Merged(Parts),
    /// It was traced before, in memory. One picture is made of it.
    Given {
        /// The light.
        light: &'a Light,
        /// The number of the frame that decides its temporal noise.
        frame: u32,
    },
}

/// What of a render into a folder does not stand in its capture.
pub struct Request<'a> {
    /// The file that the capture was read from.
    pub input: &'a Path,
    /// The input as reports name it: relative to their folder, or to the data set file.
    pub named: String,
    /// Where its light comes from.
    pub light: LightSource<'a>,
    /// Memory for its film.
    pub film_memory: FilmMemory,
    /// Hears of it, and may stop it.
    pub monitor: &'a dyn Monitor,
    /// Whether the report says how long it took, which differs from run to run.
    pub is_timed: bool,
}

impl LightSource<'_> {
    /// The number of the first frame that is made.
    pub(super) fn frame(&self) -> u32 {
        match *self {
            Self::Given { frame, .. } => frame,
            Self::Traced | Self::Part(_) | Self::Merged(_) => 0,
        }
    }
}
